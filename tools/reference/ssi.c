/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated parts of src/ssi/README.md from the models and limits themselves.
 */
#include <stdio.h>

#include "drehgeber/devices.h"
#include "drehgeber/ssi.h"
#include "parts.h"

static void print_model_row(const struct dg_device *device)
{
    static const char *const codes[DG_SSI_CODE_COUNT] = {"Gray", "binary"};
    static const char *const errors[DG_SSI_ERROR_BIT_COUNT] = {"", ", error bit (1: error)",
                                                               ", error bit (0: error)"};
    static const char *const parities[DG_SSI_PARITY_COUNT] = {"", ", even parity", ", odd parity"};
    const struct dg_ssi_model *model = dg_ssi_model_of(device);
    const unsigned bits = dg_ssi_word_bits(model);

    printf("| `%s` | %u | %u | %s | position%s%s: %u bit | %u | %u us |\n", device->name,
           model->multiturn_bits, model->singleturn_bits, codes[model->code],
           errors[model->error_bit], parities[model->parity], bits, bits + 1u,
           (unsigned)(model->monoflop / 1000u));
}

static int print_models(void)
{
    puts("| model | MT | ST | code | word behind the first rising edge | clocks | tm |");
    puts("|---|---|---|---|---|---|---|");
    print_model_row(&dg_ssi_13);
    print_model_row(&dg_ssi_25);
    print_model_row(&dg_ssi_28);
    return 0;
}

static int print_causes(void)
{
    puts("| cause of the error bit | limit |");
    puts("|---|---|");
    printf("| LED current | above %u mA |\n", DG_SSI_LED_MAX_UA / 1000u);
    printf("| amplitude of sine or cosine | outside %u to %u permille |\n",
           DG_SSI_AMPLITUDE_MIN_PERMILLE, DG_SSI_AMPLITUDE_MAX_PERMILLE);
    printf("| offset of sine or cosine | beyond %d permille |\n", DG_SSI_OFFSET_MAX_PERMILLE);
    printf("| temperature | below %d, above %d degC |\n", DG_SSI_TEMPERATURE_MIN_MDEGC / 1000,
           DG_SSI_TEMPERATURE_MAX_MDEGC / 1000);
    printf("| supply | below %u mV |\n", DG_SSI_SUPPLY_MIN_MV);
    puts("| singleturn track | not ok |");
    puts("| multiturn sensor: amplitude, synchronism, vector | not ok; with multiturn bits only |");
    puts("| watchdog | fired |");
    return 0;
}

int main(int argc, char **argv)
{
    static const struct part parts[] = {
        {"models", print_models},
        {"causes", print_causes},
    };
    return print_one(argc, argv, parts, DG_COUNT(parts));
}
