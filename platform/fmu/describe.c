/* SPDX-License-Identifier: MIT */
#include "describe.h"

#include <inttypes.h>

#include "drehgeber/version.h"

/* "in units of SI" of those that settings and variables have. */
/* clang-format off */
static const char units[] =
    "    <Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n"
    "    <Unit name=\"us\"><BaseUnit s=\"1\" factor=\"1e-6\"/></Unit>\n"
    "    <Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>\n"
    "    <Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit>\n"
    "    <Unit name=\"V\"><BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\"/></Unit>\n"
    "    <Unit name=\"mV\"><BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\" factor=\"0.001\"/></Unit>\n"
    "    <Unit name=\"uA\"><BaseUnit A=\"1\" factor=\"1e-6\"/></Unit>\n"
    "    <Unit name=\"degC\"><BaseUnit K=\"1\" offset=\"273.15\"/></Unit>\n"
    "    <Unit name=\"permille\"><BaseUnit factor=\"0.001\"/></Unit>\n";
/* clang-format on */

static void escaped(const char *text, FILE *to)
{
    static const struct {
        char c;
        const char *as;
    } rows[] = {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
    for (; *text != '\0'; text++) {
        const char *as = NULL;
        for (size_t i = 0; i < DG_COUNT(rows); i++) {
            as = rows[i].c == *text ? rows[i].as : as;
        }
        if (as != NULL) {
            (void)fputs(as, to);
        } else {
            (void)fputc(*text, to);
        }
    }
}

static void attribute(const char *name, const char *value, FILE *to)
{
    (void)fprintf(to, " %s=\"", name);
    escaped(value, to);
    (void)fputc('"', to);
}

static const char *causality(const struct fmu_variable *row)
{
    if (row->reference == 0) {
        return "independent";
    }
    return row->parameter ? "parameter" : row->input ? "input" : "output";
}

static const char *variability(const struct fmu_variable *row)
{
    return row->parameter ? "fixed" : row->continuous ? "continuous" : "discrete";
}

/* --- FMI 3 --- */

static void name3(const struct fmu_variable *row, const char *type, FILE *to)
{
    (void)fprintf(to, "    <%s", type);
    attribute("name", row->name, to);
    (void)fprintf(to, " valueReference=\"%" PRIu32 "\" causality=\"%s\"", row->reference,
                  causality(row));
    if (row->type != FMU_CLOCK) {
        attribute("variability", variability(row), to);
    }
    if (row->help[0] != '\0') {
        attribute("description", row->help, to);
    }
}

/* The clock of a wire's bytes, and of what MA latches. */
static void clocked_by(const struct fmu_variable *row, unsigned index, FILE *to)
{
    (void)fprintf(to, " clocks=\"%" PRIu32 "\"",
                  (row->reference & ~UINT32_C(0xFFFF)) | (uint32_t)FMU_BUS << 8 | index);
}

static void binary3(const struct fmu_variable *row, FILE *to)
{
    name3(row, "Binary", to);
    clocked_by(row, row->input ? FMU_RX_CLOCK : FMU_TX_CLOCK, to);
    (void)fprintf(to, " maxSize=\"%zu\"", row->room);
    attribute("mimeType",
              row->wire == 'c' ? "application/org.fmi-standard.fmi-ls-bus.can; version=\"1.0.0\""
                               : "application/x-drehgeber-rs485; version=\"1\"",
              to);
    (void)fputs(row->input ? "><Start value=\"\"/></Binary>\n" : "/>\n", to);
}

static void text3(const struct fmu_variable *row, FILE *to)
{
    name3(row, "String", to);
    (void)fputs("><Start", to);
    attribute("value", row->start, to);
    (void)fputs("/></String>\n", to);
}

static void number3(const struct fmu_variable *row, FILE *to)
{
    static const char *const types[FMU_TYPE_COUNT] = {
        [FMU_REAL] = "Float64", [FMU_INT] = "Int64", [FMU_BOOL] = "Boolean"};
    name3(row, types[row->type], to);
    if (row->input) {
        attribute("start", row->start, to);
    }
    if (row->type == FMU_REAL && row->unit[0] != '\0') {
        attribute("unit", row->unit, to);
    }
    if (row->type == FMU_INT && row->parameter) {
        (void)fprintf(to, " min=\"%" PRId64 "\" max=\"%" PRId64 "\"", row->min, row->max);
    }
    (void)fputs("/>\n", to);
}

static void clock3(const struct fmu_variable *row, FILE *to)
{
    name3(row, "Clock", to);
    (void)fputs(" intervalVariability=\"triggered\"/>\n", to);
}

static void variable3(const struct fmu_variable *row, FILE *to)
{
    static void (*const writers[])(const struct fmu_variable *row, FILE *to) = {
        [FMU_REAL] = number3, [FMU_INT] = number3,    [FMU_BOOL] = number3,
        [FMU_TEXT] = text3,   [FMU_BINARY] = binary3, [FMU_CLOCK] = clock3};
    _Static_assert(DG_COUNT(writers) == FMU_TYPE_COUNT, "each type is written");
    writers[row->type](row, to);
}

static bool is_output(const struct fmu_variable *row)
{
    return row->reference != 0 && !row->input;
}

static void structure3(struct fmu *self, FILE *to)
{
    struct fmu_variable row;
    for (size_t i = 0; fmu_variable(self, i, &row); i++) {
        if (is_output(&row)) {
            (void)fprintf(to, "    <Output valueReference=\"%" PRIu32 "\"/>\n", row.reference);
        }
    }
    for (size_t i = 0; fmu_variable(self, i, &row); i++) {
        if (is_output(&row) && row.type != FMU_BINARY) {
            (void)fprintf(to, "    <InitialUnknown valueReference=\"%" PRIu32 "\"/>\n",
                          row.reference);
        }
    }
}

static void describe3(struct fmu *self, const struct fmu_about *about, FILE *to)
{
    struct fmu_variable row;
    (void)fputs("<fmiModelDescription fmiVersion=\"3.0\"", to);
    attribute("modelName", about->name, to);
    attribute("instantiationToken", about->token, to);
    (void)fprintf(to,
                  " description=\"Virtual absolute encoders\" version=\"" DG_VERSION
                  "\" license=\"MIT\" generationTool=\"drehgeber " DG_VERSION
                  "\" variableNamingConvention=\"structured\">\n"
                  "  <CoSimulation modelIdentifier=\"drehgeber\" hasEventMode=\"true\""
                  " canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"true\""
                  " canSerializeFMUState=\"true\"/>\n  <UnitDefinitions>\n%s  </UnitDefinitions>\n"
                  "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"0.001\"/>\n"
                  "  <ModelVariables>\n",
                  units);
    for (size_t i = 0; fmu_variable(self, i, &row); i++) {
        variable3(&row, to);
    }
    (void)fputs("  </ModelVariables>\n  <ModelStructure>\n", to);
    structure3(self, to);
    (void)fputs("  </ModelStructure>\n</fmiModelDescription>\n", to);
}

/* --- FMI 2: what has neither bytes, nor clocks, nor 64 bits --- */

static bool is_of_2(const struct fmu_variable *row)
{
    return row->type != FMU_BINARY && row->type != FMU_CLOCK &&
           (row->reference & 0xFFFFu) != ((uint32_t)FMU_OUTPUT << 8 | FMU_FRAME);
}

static const char *type2(const struct fmu_variable *row)
{
    if (row->type == FMU_INT) {
        return row->parameter && row->max <= INT32_MAX ? "Integer" : "Real";
    }
    return row->type == FMU_REAL ? "Real" : row->type == FMU_BOOL ? "Boolean" : "String";
}

static void variable2(const struct fmu_variable *row, FILE *to)
{
    (void)fputs("    <ScalarVariable", to);
    attribute("name", row->name, to);
    (void)fprintf(to, " valueReference=\"%" PRIu32 "\" causality=\"%s\" variability=\"%s\"",
                  row->reference, causality(row), variability(row));
    if (row->help[0] != '\0') {
        attribute("description", row->help, to);
    }
    (void)fprintf(to, "><%s", type2(row));
    if (row->input) {
        attribute("start", row->start, to);
    }
    if (row->type == FMU_REAL && row->unit[0] != '\0') {
        attribute("unit", row->unit, to);
    }
    (void)fputs("/></ScalarVariable>\n", to);
}

/* Indices of the outputs, counted from 1. */
static void unknowns2(struct fmu *self, const char *list, FILE *to)
{
    struct fmu_variable row;
    unsigned index = 0;
    (void)fprintf(to, "    <%s>\n", list);
    for (size_t i = 0; fmu_variable(self, i, &row); i++) {
        index += is_of_2(&row) ? 1 : 0;
        if (is_of_2(&row) && is_output(&row)) {
            (void)fprintf(to, "      <Unknown index=\"%u\"/>\n", index);
        }
    }
    (void)fprintf(to, "    </%s>\n", list);
}

static void describe2(struct fmu *self, const struct fmu_about *about, FILE *to)
{
    struct fmu_variable row;
    (void)fputs("<fmiModelDescription fmiVersion=\"2.0\"", to);
    attribute("modelName", about->name, to);
    attribute("guid", about->token, to);
    (void)fprintf(to,
                  " description=\"Virtual absolute encoders\" version=\"" DG_VERSION
                  "\" license=\"MIT\" generationTool=\"drehgeber " DG_VERSION
                  "\" variableNamingConvention=\"structured\">\n"
                  "  <CoSimulation modelIdentifier=\"drehgeber\""
                  " canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\""
                  " canSerializeFMUstate=\"true\"><SourceFiles>\n");
    for (size_t i = 0; i < about->source_count; i++) {
        (void)fprintf(to, "    <File name=\"%s\"/>\n", about->sources[i]);
    }
    (void)fputs("  </SourceFiles></CoSimulation>\n", to);
    (void)fprintf(to,
                  "  <UnitDefinitions>\n%s  </UnitDefinitions>\n"
                  "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"0.001\"/>\n"
                  "  <ModelVariables>\n",
                  units);
    for (size_t i = 0; fmu_variable(self, i, &row); i++) {
        if (is_of_2(&row)) {
            variable2(&row, to);
        }
    }
    (void)fputs("  </ModelVariables>\n  <ModelStructure>\n", to);
    unknowns2(self, "Outputs", to);
    unknowns2(self, "InitialUnknowns", to);
    (void)fputs("  </ModelStructure>\n</fmiModelDescription>\n", to);
}

void fmu_describe(struct fmu *self, const struct fmu_about *about, int version, FILE *to)
{
    (void)fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n", to);
    (version == 2 ? describe2 : describe3)(self, about, to);
}

/* --- buses of FMI 3 --- */

static bool is_can(const struct fmu *self, size_t encoder)
{
    return dg_host_medium(fmu_host(self, encoder)) == DG_HOST_MEDIUM_FRAMES;
}

bool fmu_has_bus(const struct fmu *self)
{
    for (size_t i = 0; i < fmu_count(self); i++) {
        if (is_can(self, i)) {
            return true;
        }
    }
    return false;
}

void fmu_describe_terminals(const struct fmu *self, FILE *to)
{
    static const char *const members[] = {"Rx_Data", "Tx_Data", "Rx_Clock", "Tx_Clock"};
    (void)fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                "<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n  <Terminals>\n",
                to);
    for (size_t i = 0; i < fmu_count(self); i++) {
        const char *prefix = fmu_wire_prefix(self, i);
        if (!is_can(self, i) || prefix == NULL) {
            continue;
        }
        (void)fprintf(to,
                      "    <Terminal name=\"%sCanChannel\""
                      " terminalKind=\"org.fmi-ls-bus.network-terminal\""
                      " matchingRule=\"org.fmi-ls-bus.transceiver\">\n",
                      prefix);
        for (size_t k = 0; k < DG_COUNT(members); k++) {
            (void)fprintf(to,
                          "      <TerminalMemberVariable variableName=\"%sCanChannel.%s\""
                          " memberName=\"%s\" variableKind=\"signal\"/>\n",
                          prefix, members[k], members[k]);
        }
        (void)fputs("    </Terminal>\n", to);
    }
    (void)fputs("  </Terminals>\n</fmiTerminalsAndIcons>\n", to);
}

void fmu_describe_build(const struct fmu_about *about, FILE *to)
{
    (void)fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                "<fmiBuildDescription fmiVersion=\"3.0\">\n"
                "  <BuildConfiguration modelIdentifier=\"drehgeber\">\n"
                "    <SourceFileSet language=\"C11\">\n",
                to);
    for (size_t i = 0; i < about->source_count; i++) {
        (void)fprintf(to, "      <SourceFile name=\"%s\"/>\n", about->sources[i]);
    }
    (void)fputs("      <IncludeDirectory name=\".\"/>\n    </SourceFileSet>\n"
                "  </BuildConfiguration>\n</fmiBuildDescription>\n",
                to);
}

void fmu_describe_bus(FILE *to)
{
    (void)fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                "<fmiLayeredStandardManifest"
                " xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\""
                " fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-bus\""
                " fmi-ls:fmi-ls-version=\"1.0.0\""
                " fmi-ls:fmi-ls-description=\"Buses of encoders\""
                " isBusSimulationFMU=\"false\"/>\n",
                to);
}
