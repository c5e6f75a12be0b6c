/* SPDX-License-Identifier: MIT */
/* The texts of an FMU, as the standards have them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "describe.h"
#include "fmu_rig.h"

/* What `write` would write, which lasts until the next one. */
static const char *describe_with(const char *token, const struct fmu_files *files, const char *name,
                                 int version)
{
    static char text[1 << 17];
    static char file_1[] = "src/a.c";
    static char file_2[] = "src/b.c";
    static char *const sources[] = {file_1, file_2};
    const struct fmu_about about = {token, name, sources, 2};
    struct fmu *fmu = fmu_make_with(token, files);
    FILE *file = tmpfile();
    assert_non_null(fmu);
    assert_non_null(file);
    fmu_describe(fmu, &about, version, file);
    fmu_describe_terminals(fmu, file);
    fmu_describe_build(&about, file);
    fmu_describe_bus(file);
    rewind(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    (void)fclose(file);
    fmu_free(fmu);
    return text;
}

static const char *described(const char *token, const char *name, int version)
{
    return describe_with(token, NULL, name, version);
}

/* A reader of XML takes these for what they are (XML 1.0, 2.4). */
static void names_are_escaped(void **state)
{
    (void)state;
    for (int version = 2; version <= 3; version++) {
        assert_non_null(strstr(described(TOKEN " =f3668", "a&b<c>d\"e", version),
                               " modelName=\"a&amp;b&lt;c&gt;d&quot;e\" "));
    }
}

/* Lines, as the standards have each kind of variable. */
static const struct {
    int version;
    const char *line;
} lines[] = {
    {3, "\n    <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\""
        " variability=\"continuous\" unit=\"s\"/>\n"},
    {3, "\n    <Float64 name=\"a.shaft.angle\" valueReference=\"256\" causality=\"input\""
        " variability=\"continuous\" description=\"of the shaft, clockwise looking at it, any"
        " number of turns\" start=\"0\" unit=\"rad\"/>\n"},
    {3, "\n    <Boolean name=\"b.power\" valueReference=\"65794\" causality=\"input\""
        " variability=\"discrete\" description=\"supply: off and on again is a restart\""
        " start=\"true\"/>\n"},
    {3, "\n    <Int64 name=\"a.node\" valueReference=\"512\" causality=\"parameter\""
        " variability=\"fixed\" description=\"node-ID of a new EEPROM\" start=\"63\" min=\"1\""
        " max=\"127\"/>\n"},
    {3, "\n    <String name=\"a.mt_bits\" valueReference=\"514\" causality=\"parameter\""
        " variability=\"fixed\" description=\"bits of the turns: 12, 16\"><Start"
        " value=\"12\"/></String>\n"},
    {3, "\n    <Float64 name=\"a.world.temperature\" valueReference=\"771\" causality=\"input\""
        " variability=\"continuous\" description=\"in the housing\" start=\"37.000\""
        " unit=\"degC\"/>\n"},
    {3, " causality=\"input\" variability=\"discrete\" description=\"the watchdog has reset the"
        " processor\" start=\"false\"/>\n"},
    {3, " causality=\"input\" variability=\"discrete\" description=\"the EEPROM acknowledges\""
        " start=\"true\"/>\n"},
    {3, "\n    <Boolean name=\"a.fault.error_passive\" valueReference=\"1041\""
        " causality=\"input\" variability=\"discrete\" description=\"many damaged frames -&gt;"
        " EMCY 8120h, 1001h 11h\" start=\"false\"/>\n"},
    {3, "\n    <Int64 name=\"a.position\" valueReference=\"1280\" causality=\"output\""
        " variability=\"discrete\" description=\"counts as the wire would tell them now\"/>\n"},
    {3, "\n    <Float64 name=\"b.sin_plus\" valueReference=\"66817\" causality=\"output\""
        " variability=\"continuous\" description=\"process channel SIN+\" unit=\"V\"/>\n"},
    {3, "\n    <Binary name=\"a.CanChannel.Rx_Data\" valueReference=\"1536\""
        " causality=\"input\" variability=\"discrete\" description=\"operations of FMI-LS-BUS"
        " from the bus\" clocks=\"1538\" maxSize=\"2048\""
        " mimeType=\"application/org.fmi-standard.fmi-ls-bus.can; version=&quot;1.0.0&quot;\">"
        "<Start value=\"\"/></Binary>\n"},
    {3, "\n    <Binary name=\"b.RS485.Tx_Data\" valueReference=\"67073\" causality=\"output\""
        " variability=\"discrete\" description=\"characters of the encoder\" clocks=\"67075\""
        " maxSize=\"2048\""
        " mimeType=\"application/x-drehgeber-rs485; version=&quot;1&quot;\"/>\n"},
    {3, "\n    <Clock name=\"a.CanChannel.Rx_Clock\" valueReference=\"1538\""
        " causality=\"input\" description=\"Rx_Data comes\""
        " intervalVariability=\"triggered\"/>\n"},
    {3, "<ModelStructure>\n"
        "    <Output valueReference=\"1280\"/>\n"
        "    <Output valueReference=\"1291\"/>\n"
        "    <Output valueReference=\"1292\"/>\n"
        "    <Output valueReference=\"1293\"/>\n"
        "    <Output valueReference=\"1537\"/>\n"
        "    <Output valueReference=\"1539\"/>\n"
        "    <Output valueReference=\"66816\"/>\n"},
    {3, "    <InitialUnknown valueReference=\"1280\"/>\n"
        "    <InitialUnknown valueReference=\"1291\"/>\n"
        "    <InitialUnknown valueReference=\"1292\"/>\n"
        "    <InitialUnknown valueReference=\"1293\"/>\n"
        "    <InitialUnknown valueReference=\"1539\"/>\n"
        "    <InitialUnknown valueReference=\"66816\"/>\n"},
    {2, "\n    <ScalarVariable name=\"time\" valueReference=\"0\" causality=\"independent\""
        " variability=\"continuous\"><Real unit=\"s\"/></ScalarVariable>\n"},
    {2, "\n    <ScalarVariable name=\"a.node\" valueReference=\"512\" causality=\"parameter\""
        " variability=\"fixed\" description=\"node-ID of a new EEPROM\"><Integer start=\"63\""
        "/></ScalarVariable>\n"},
    {2, "description=\"serial number of a new EEPROM\"><Real start=\"1234567890\""
        "/></ScalarVariable>\n"},
    {2, "description=\"bits of the turns: 12, 16\"><String start=\"12\""
        "/></ScalarVariable>\n"},
    {2, "description=\"supply: off and on again is a restart\"><Boolean start=\"true\""
        "/></ScalarVariable>\n"},
    {2, "description=\"in the housing\"><Real start=\"37.000\" unit=\"degC\""
        "/></ScalarVariable>\n"},
    {2, "description=\"counts as the wire would tell them now\"><Real/></ScalarVariable>\n"},
    {2, "    <File name=\"src/a.c\"/>\n    <File name=\"src/b.c\"/>\n  </SourceFiles>"},
};

/* Each kind of variable; an encoder that follows a shaft has none for it. */
static void each_kind_of_variable_is_described(void **state)
{
    static const char *const nowhere[] = {"\"b.shaft.angle\"", "\"b.shaft.speed\"",
                                          "\"b.MA\"",          "\"b.frame\"",
                                          "\"a.sin_plus\"",    "\"b.error.code\""};

    (void)state;
    for (int version = 2; version <= 3; version++) {
        char token[RIG_TOKEN_MAX];
        const struct fmu_files files =
            fmu_rig_files("[encoder a]\nmodel = f3668\nwire = slcan\n"
                          "[encoder b]\nmodel = s3684-rs485\nwire = pty\n",
                          token);
        const char *text = describe_with(token, &files, "two", version);
        for (size_t i = 0; i < DG_COUNT(lines); i++) {
            if (lines[i].version == version && strstr(text, lines[i].line) == NULL) {
                fail_msg("no %s", lines[i].line);
            }
        }
        for (size_t k = 0; k < DG_COUNT(nowhere); k++) {
            assert_null(strstr(text, nowhere[k]));
        }
    }
}

/* FMI 2.0, 2.2.8: outputs by their place among the variables, counted from 1. */
static void outputs_of_fmi_2_are_counted_from_1(void **state)
{
    static const char last[] = "<ScalarVariable name=\"nWARN\"";
    static const char *const wires[] = {"<Clock", "\"MA\"", "<Binary", "\"frame\""};

    (void)state;
    const char *text = described(TOKEN " =s3684-biss", "one", 2);
    const char *end = strstr(text, "</ModelVariables>");
    assert_non_null(end);
    assert_non_null(strstr(text, last));
    unsigned count = 0;
    for (const char *at = strstr(text, "<ScalarVariable"); at != NULL && at < end; count++) {
        at = strstr(at + 1, "<ScalarVariable");
    }
    for (size_t i = 0; i < DG_COUNT(wires); i++) {
        const char *at = strstr(text, wires[i]);
        assert_true(at == NULL || at > end);
    }
    /* position, frame.bits, frame.position, frame.good, nERR and nWARN are the last ones. */
    for (int list = 0; list < 2; list++) {
        char wanted[512];
        static const char *const lists[] = {"Outputs", "InitialUnknowns"};
        size_t n = (size_t)snprintf(wanted, sizeof wanted, "    <%s>\n", lists[list]);
        for (unsigned i = 5; i < 6; i--) {
            n += (size_t)snprintf(wanted + n, sizeof wanted - n, "      <Unknown index=\"%u\"/>\n",
                                  count - i);
        }
        (void)snprintf(wanted + n, sizeof wanted - n, "    </%s>\n", lists[list]);
        assert_non_null(strstr(text, wanted));
    }
}

/* FMI-LS-BUS 1.0: a terminal for each CAN, and a manifest; FMI 3.0, 2.5.1.3: what to compile. */
static void buses_and_sources_are_described(void **state)
{
    static const char terminals[] =
        "<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n"
        "  <Terminals>\n"
        "    <Terminal name=\"b.CanChannel\" terminalKind=\"org.fmi-ls-bus.network-terminal\""
        " matchingRule=\"org.fmi-ls-bus.transceiver\">\n"
        "      <TerminalMemberVariable variableName=\"b.CanChannel.Rx_Data\" memberName=\"Rx_Data\""
        " variableKind=\"signal\"/>\n"
        "      <TerminalMemberVariable variableName=\"b.CanChannel.Tx_Data\" memberName=\"Tx_Data\""
        " variableKind=\"signal\"/>\n"
        "      <TerminalMemberVariable variableName=\"b.CanChannel.Rx_Clock\""
        " memberName=\"Rx_Clock\" variableKind=\"signal\"/>\n"
        "      <TerminalMemberVariable variableName=\"b.CanChannel.Tx_Clock\""
        " memberName=\"Tx_Clock\" variableKind=\"signal\"/>\n"
        "    </Terminal>\n"
        "  </Terminals>\n"
        "</fmiTerminalsAndIcons>\n";
    static const char build[] = "    <SourceFileSet language=\"C11\">\n"
                                "      <SourceFile name=\"src/a.c\"/>\n"
                                "      <SourceFile name=\"src/b.c\"/>\n"
                                "      <IncludeDirectory name=\".\"/>\n"
                                "    </SourceFileSet>\n";
    static const char manifest[] = " fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-bus\""
                                   " fmi-ls:fmi-ls-version=\"1.0.0\"";
    static const struct {
        const char *token;
        bool bus;
    } rows[] = {{TOKEN " =s3684-biss", false}, {TOKEN " =f3658", true}};
    char token[RIG_TOKEN_MAX];
    const struct fmu_files files = fmu_rig_files("[encoder a]\nmodel = s3684-biss\nwire = sim\n"
                                                 "[encoder b]\nmodel = f3668\nwire = slcan\n"
                                                 "[encoder c]\nmodel = ssi-25\nwire = sim\n",
                                                 token);

    (void)state;
    const char *text = describe_with(token, &files, "three", 3);
    assert_non_null(strstr(text, terminals));
    assert_non_null(strstr(text, build));
    assert_non_null(strstr(text, manifest));
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct fmu *fmu = fmu_make(rows[i].token);
        assert_non_null(fmu);
        assert_int_equal(fmu_has_bus(fmu), rows[i].bus);
        fmu_free(fmu);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_escaped),
        cmocka_unit_test(each_kind_of_variable_is_described),
        cmocka_unit_test(outputs_of_fmi_2_are_counted_from_1),
        cmocka_unit_test(buses_and_sources_are_described),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
