/* SPDX-License-Identifier: MIT */
#include "pio.h"

void pio_load(uint32_t pio, uint32_t at, const uint16_t *program, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        REG(pio + PIO_INSTR_MEM(at + i)) = program[i];
    }
}

void pio_set_up(const struct pio_machine *machine)
{
    const uint32_t at = machine->pio + PIO_SM(machine->index);

    REG(at + PIO_SM_CLKDIV) = machine->clkdiv;
    REG(at + PIO_SM_EXECCTRL) =
        machine->execctrl | (uint32_t)machine->wrap_from << 12 | (uint32_t)machine->wrap_to << 7;
    REG(at + PIO_SM_SHIFTCTRL) = machine->shiftctrl;
    REG(at + PIO_SM_PINCTRL) = machine->pinctrl;
    pio_do(machine, PIO_JMP(PIO_ALWAYS, machine->start));
}

void pio_direct(const struct pio_machine *machine, uint32_t pin)
{
    const uint32_t at = machine->pio + PIO_SM(machine->index) + PIO_SM_PINCTRL;

    REG(at) = 1u << 26 | pin << 5;
    pio_do(machine, PIO_SET(PIO_PINDIRS, 1));
    REG(at) = machine->pinctrl;
}

void pio_run(const struct pio_machine *machine, int on)
{
    const uint32_t bit = 1u << machine->index;

    if (on) {
        REG_SET(machine->pio + PIO_CTRL) = bit;
    } else {
        REG_CLR(machine->pio + PIO_CTRL) = bit;
    }
}
