/* SPDX-License-Identifier: MIT */
/*
 * A CAN master as an FMU, for a container to couple with an encoder's: starts all nodes after half
 * a second, then sends SYNC in every step, and counts the TPDO2 of node 5.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define FMI3(type, name, arguments)                                                                \
    type name arguments;                                                                           \
    type name arguments

enum { RX, TX, RX_CLOCK, TX_CLOCK, COUNT, POSITION };

struct master {
    bool rx, tx, configured, started;
    double count, position;
    uint8_t out[64];
    size_t n;
};

static void put32(struct master *m, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) {
        m->out[m->n++] = (uint8_t)(value >> 8 * i);
    }
}

static void transmit(struct master *m, uint32_t id, uint16_t data, uint8_t length)
{
    put32(m, 0x10);
    put32(m, 16u + length);
    put32(m, id);
    put32(m, (uint32_t)length << 16);
    m->out[m->n] = (uint8_t)data;
    m->out[m->n + 1] = (uint8_t)(data >> 8);
    m->n += length;
}

FMI3(const char *, fmi3GetVersion, (void))
{
    return "3.0";
}

FMI3(void *, fmi3InstantiateCoSimulation, (void))
{
    return calloc(1, sizeof(struct master));
}

FMI3(void, fmi3FreeInstance, (void *of))
{
    free(of);
}

FMI3(int, fmi3DoStep,
     (struct master * m, double now, double span, bool no, bool *event, bool *end, bool *early,
      double *last))
{
    (void)no;
    m->n = 0;
    if (!m->configured) { /* CAN_BAUDRATE 250000 */
        put32(m, 0x40);
        put32(m, 13);
        m->out[m->n++] = 1;
        put32(m, 250000);
        m->configured = true;
    } else if (now >= 0.5 && !m->started) {
        transmit(m, 0, 0x0001, 2);
        m->started = true;
    } else if (m->started) {
        transmit(m, 0x80, 0, 0);
    }
    m->tx = m->n > 0;
    *event = m->tx;
    *end = *early = false;
    *last = now + span;
    return 0;
}

FMI3(int, fmi3UpdateDiscreteStates,
     (struct master * m, bool *a, bool *b, bool *c, bool *d, bool *e, double *next))
{
    m->rx = false;
    *a = *b = *c = *d = *e = false;
    *next = 0;
    return 0;
}

FMI3(int, fmi3GetClock, (struct master * m, const uint32_t vr[], size_t n, bool values[]))
{
    for (size_t i = 0; i < n; i++) {
        values[i] = vr[i] == TX_CLOCK ? m->tx : m->rx;
    }
    return 0;
}

FMI3(int, fmi3SetClock, (struct master * m, const uint32_t vr[], size_t n, const bool values[]))
{
    for (size_t i = 0; i < n; i++) {
        m->rx = vr[i] == RX_CLOCK ? values[i] : m->rx;
    }
    return 0;
}

FMI3(int, fmi3GetBinary,
     (struct master * m, const uint32_t vr[], size_t n, size_t sizes[], const uint8_t *values[],
      size_t nv))
{
    (void)nv;
    for (size_t i = 0; i < n; i++) {
        values[i] = m->out;
        sizes[i] = vr[i] == TX && m->tx ? m->n : 0;
        m->tx = false;
    }
    return 0;
}

FMI3(int, fmi3SetBinary,
     (struct master * m, const uint32_t vr[], size_t n, const size_t sizes[],
      const uint8_t *const values[], size_t nv))
{
    (void)vr;
    (void)nv;
    for (size_t i = 0; i < n && m->rx; i++) {
        for (size_t at = 0; at + 8 <= sizes[i];) {
            uint32_t head[3];
            memcpy(head, values[i] + at, sizeof head);
            if (head[0] == 0x10 && head[2] == 0x285) {
                uint32_t position;
                memcpy(&position, values[i] + at + 16, sizeof position);
                m->count += 1;
                m->position = position;
            }
            at += head[1];
        }
    }
    return 0;
}

FMI3(int, fmi3GetFloat64,
     (struct master * m, const uint32_t vr[], size_t n, double values[], size_t nv))
{
    (void)nv;
    for (size_t i = 0; i < n; i++) {
        values[i] = vr[i] == COUNT ? m->count : m->position;
    }
    return 0;
}

/* What a container looks for and this one does not need. */
#define STUB(name)                                                                                 \
    FMI3(int, fmi3##name, (void))                                                                  \
    {                                                                                              \
        return 0;                                                                                  \
    }
STUB(ActivateModelPartition)
STUB(CompletedIntegratorStep)
STUB(DeserializeFMUState)
STUB(EnterConfigurationMode)
STUB(EnterContinuousTimeMode)
STUB(EnterEventMode)
STUB(EnterInitializationMode)
STUB(EnterStepMode)
STUB(EvaluateDiscreteStates)
STUB(ExitConfigurationMode)
STUB(ExitInitializationMode)
STUB(FreeFMUState)
STUB(GetAdjointDerivative)
STUB(GetBoolean)
STUB(GetContinuousStateDerivatives)
STUB(GetContinuousStates)
STUB(GetDirectionalDerivative)
STUB(GetEventIndicators)
STUB(GetFMUState)
STUB(GetFloat32)
STUB(GetInt16)
STUB(GetInt32)
STUB(GetInt64)
STUB(GetInt8)
STUB(GetIntervalDecimal)
STUB(GetIntervalFraction)
STUB(GetNominalsOfContinuousStates)
STUB(GetNumberOfContinuousStates)
STUB(GetNumberOfEventIndicators)
STUB(GetNumberOfVariableDependencies)
STUB(GetOutputDerivatives)
STUB(GetShiftDecimal)
STUB(GetShiftFraction)
STUB(GetString)
STUB(GetUInt16)
STUB(GetUInt32)
STUB(GetUInt64)
STUB(GetUInt8)
STUB(GetVariableDependencies)
STUB(InstantiateModelExchange)
STUB(InstantiateScheduledExecution)
STUB(Reset)
STUB(SerializeFMUState)
STUB(SerializedFMUStateSize)
STUB(SetBoolean)
STUB(SetContinuousStates)
STUB(SetDebugLogging)
STUB(SetFMUState)
STUB(SetFloat32)
STUB(SetFloat64)
STUB(SetInt16)
STUB(SetInt32)
STUB(SetInt64)
STUB(SetInt8)
STUB(SetIntervalDecimal)
STUB(SetIntervalFraction)
STUB(SetShiftDecimal)
STUB(SetShiftFraction)
STUB(SetString)
STUB(SetTime)
STUB(SetUInt16)
STUB(SetUInt32)
STUB(SetUInt64)
STUB(SetUInt8)
STUB(Terminate)
