/* SPDX-License-Identifier: MIT */
/*
 * The language: rules of IEEE 488.2-1992 (chapters 7, 8 and 10) and SCPI-99 volume 1 (chapter 6),
 * each with lines that keep and lines that break it. Numbers have a test of their own.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "scpi_private.h"
#include "scpi_rig.h"

#define NONE "0,\"No error\"\n"

/* What is sent, what is answered, and what SYSTem:ERRor:ALL? says then. */
struct row {
    const char *rule;
    const char *line;
    const char *answer;
    const char *errors;
};

static struct scpi_rig rig;

static void check(const struct row *row)
{
    char answer[SCPI_RIG_OUT_MAX];

    scpi_rig_init(&rig);
    scpi_rig_send(&rig, row->line);
    memcpy(answer, rig.out, sizeof answer);
    scpi_rig_send(&rig, "SYST:ERR:ALL?\n");
    if (strcmp(answer, row->answer) != 0 || strcmp(rig.out, row->errors) != 0) {
        print_error("%s\n  sent   %s\n  answer %s\n  errors %s\n", row->rule, row->line, answer,
                    rig.out);
    }
    assert_string_equal(answer, row->answer);
    assert_string_equal(rig.out, row->errors);
    assert_false(rig.lost);
}

static void check_all(const struct row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        check(&rows[i]);
    }
}

#define UNDEFINED(header) "-113,\"Undefined header;" header "\"\n"

/* clang-format off */
static const struct row headers[] = {
    {"6.2.1 long form",               "SHAFT:POSITION 1REV;POSITION?\n",   "4294967296\n", NONE},
    {"6.2.1 short form",              "SHAF:POS 1REV;POS?\n",              "4294967296\n", NONE},
    {"6.2.1 both forms in a header",  "SHAFT:POS 1REV;POSITION?\n",        "4294967296\n", NONE},
    {"6.2.1 any case",                "sHaFt:pOs 1rEv;Position?\n",        "4294967296\n", NONE},
    {"6.2.1 nothing in between",      "SHAF:POSI?\n",     "", UNDEFINED("SHAF:POSI?; closest is SHAFt:POSition?")},
    {"6.2.1 nothing shorter",         "SHA:POS?\n",       "", UNDEFINED("SHA:POS?; closest is SHAFt:POSition?")},
    {"6.2.1 nothing longer",          "SHAF:POSITIONS?\n", "", UNDEFINED("SHAF:POSITIONS?; closest is SHAFt:POSition?")},
    {"6.2.1 all nodes",               "POS?\n",           "", UNDEFINED("POS?; closest is SHAFt:POSition?")},
    {"6.2.1 no nodes but those",      "SHAF?\n",          "", UNDEFINED("SHAF?; closest is SHAFt:POSition?")},
    {"6.2.1 no nodes behind",         "SHAF:POS:X?\n",    "", UNDEFINED("SHAF:POS:X?; closest is SHAFt:POSition?")},
    {"6.2.1 no empty node",           "SHAF::POS?\n",     "", UNDEFINED("SHAF::POS?; closest is SHAFt:POSition?")},
    {"6.2.1 no empty node at the end", "SHAF:POS:?\n",    "", UNDEFINED("SHAF:POS:?; closest is SHAFt:POSition?")},
    {"6.2.1 no empty header",         "?\n",              "", UNDEFINED("?; SYSTem:HELP? has all")},
    {"6.2.1 no colon alone",          ":\n",              "", "-113,\"Undefined header;SYSTem:HELP? has all\"\n"},
    {"6.2.2 optional nodes left out", "VAL 0.5;VAL?\n",   "0.500\n", NONE},
    {"6.2.2 optional nodes sent",     "SENSE:VAL:NOW 0.5;:SENS:VALUE:NOW?\n", "0.500\n", NONE},
    {"6.2.2 the first of two",        ":SENS:VAL 0.5;:SENS:VAL?\n", "0.500\n", NONE},
    {"6.2.2 the second of two",       "VAL:NOW 0.5;:VAL:NOW?\n",    "0.500\n", NONE},
    {"6.2.2 optional nodes in order", "NOW:VAL?\n",       "", UNDEFINED("NOW:VAL?; closest is [SENSe:]VALue[:NOW]?")},
    {"6.2.2 once",                    "VAL:NOW:NOW?\n",   "", UNDEFINED("VAL:NOW:NOW?; closest is [SENSe:]VALue[:NOW]?")},
    {"6.2.3 no query of a command",   "SHAF:STOP?\n",     "", UNDEFINED("SHAF:STOP?; expected SHAFt:STOP")},
    {"6.2.3 no command of a query",   "PART\n",           "", UNDEFINED("PART; expected PARTs? [N]")},
    {"6.2.3 one question mark",       "PART??\n",         "", UNDEFINED("PART??; closest is PARTs? [N]")},
    {"6.2.3 rows for command and query", "NUMB 5;NUMB?\n", "5\n", NONE},
    {"7.6.1.5 blank before a parameter", "SHAF:POS=1\n",  "", UNDEFINED("SHAF:POS=1; closest is SHAFt:POSition ANGLE")},
    {"7.6.1.5 no comma there",        "SHAF:POS,1\n",     "", UNDEFINED("SHAF:POS,1; closest is SHAFt:POSition ANGLE")},
    {"7.4.1.2 blanks anywhere",       " \t SHAF:POS \t 1 REV \t ; \t POS? \t \r\n", "4294967296\n", NONE},
    {"7.4.1.2 not in a header",       "SHAF: POS 1\n",    "", UNDEFINED("SHAF:; closest is SHAFt:POSition ANGLE")},
    {"near: a character too many",    "SHAF:POSS 9DEG\n",  "", UNDEFINED("SHAF:POSS; closest is SHAFt:POSition ANGLE")},
    {"near: one is missing",          "WORL:SUP 3V\n",     "", UNDEFINED("WORL:SUP; closest is WORLd:SUPPly VOLTAGE")},
    {"near: two are exchanged",       "SHFA:VEL?\n",       "", UNDEFINED("SHFA:VEL?; closest is SHAFt:VELocity?")},
    {"near: in the last node",        "FAUL:SETT x\n",     "", UNDEFINED("FAUL:SETT; closest is FAULt:SET NAME[,COUNt n][,PROBability p][,DURation TIME]")},
    {"near: a node is missing",       "FAULT x\n",         "", UNDEFINED("FAULT; closest is FAULt:SET NAME[,COUNt n][,PROBability p][,DURation TIME]")},
    {"near: a blank for the colon",   "SHAFT POS 9DEG\n",  "", UNDEFINED("SHAFT; closest is SHAFt:POSition ANGLE")},
    {"near: called as what it takes", "SHAF:SPEED 60\n",   "", UNDEFINED("SHAF:SPEED; closest is SHAFt:VELocity SPEED")},
    {"near: or as its beginning",     "WORL:VOLT 4\n",     "", UNDEFINED("WORL:VOLT; closest is WORLd:SUPPly VOLTAGE")},
    {"near: the command, not a query with less amiss", "SHAF:STO 5\n", "", UNDEFINED("SHAF:STO; closest is SHAFt:STOP")},
    {"near: no character of a header", "~HAF:POS 9DEG\n", "", UNDEFINED("~HAF:POS; SYSTem:HELP? has all")},
    {"near: three of five is too far", "SHAF:SXEXX 5\n",   "", UNDEFINED("SHAF:SXEXX; SYSTem:HELP? has all")},
    {"near: seven nodes are too many", "A:B:C:D:E:SHAF:POS?\n", "", UNDEFINED("A:B:C:D:E:SHAF:POS?; SYSTem:HELP? has all")},
    {"near: 17 letters are no keyword", "SHAF:POSITIONPOSITIONP?\n", "", UNDEFINED("SHAF:POSITIONPOSITIONP?; SYSTem:HELP? has all")},
    {"7.6.1 numbers are no header",   "12\n",             "", UNDEFINED("12; SYSTem:HELP? has all")},
    {"7.6.1 quotes are no header",    "\"a;b\"\n",        "", UNDEFINED("\"\"a; SYSTem:HELP? has all")},
};

static const struct row paths[] = {
    {"6.2.4 relative to the last header", "SHAF:VEL 1;POS 1REV;VEL?;POS?\n", "1000;4294967296\n", NONE},
    {"6.2.4 deeper",                 "WORL:SUPP 5;LED:CURR 7;CURR?\n",     "7\n", NONE},
    {"6.2.4 deeper step by step",    "WORL:SUPP 5;OFFS:COS 7;SIN 8;COS?;SIN?\n", "7;8\n", NONE},
    {"6.2.4 not back up",            "WORL:LED:CURR 7;SUPP?\n",            "", UNDEFINED("WORL:LED:SUPP?; closest is WORLd:SUPPly?")},
    {"6.2.4 a colon is the root",    "WORL:LED:CURR 7;:WORL:SUPP 5;SUPP?;:SHAF:VEL?\n", "5;0\n", NONE},
    {"6.2.4 a colon at the line's begin", ":SHAF:VEL 1;VEL?\n",            "1000\n", NONE},
    {"6.2.4 the root needs its colon", "SHAF:VEL 1;SHAF:VEL?\n",           "", UNDEFINED("SHAF:SHAF:VEL?; closest is SHAFt:VELocity?")},
    {"6.2.4 common commands leave it", "SHAF:VEL 1;*ESE 3;VEL?;*ESE?;VEL?\n", "1000;3;1000\n", NONE},
    {"6.2.4 common commands need none", "SHAF:VEL 1;*IDN?\n",  "drehgeber,rig,0,1.2.3\n", NONE},
    {"6.2.4 a node left out is not in it", "WORL:OFFS 4;OFFS:SIN?;COS?\n", "4;0\n", NONE},
    {"6.2.4 a node sent is in it",   "WORL:OFFS:SIN 4;OFFS:COS?\n",        "", UNDEFINED("WORL:OFFS:OFFS:COS?; closest is WORLd:OFFSet:COS?")},
    {"6.2.4 a header without nodes", "NUMB 3;NUMB?;BYTE 4;NUMB?\n",        "3;3\n", NONE},
    {"6.2.4 ends with the line",     "SHAF:VEL 1\nVEL?\n",                 "", UNDEFINED("VEL?; closest is SHAFt:VELocity?")},
    {"6.2.4 SYSTem:ERRor likewise",  "SYST:ERR?;ERR:COUN?;ALL?\n",         "0,\"No error\";0;0,\"No error\"\n", NONE},
};

static const struct row messages[] = {
    {"7.3.1 nothing",                 "\n",                    "", NONE},
    {"7.3.1 blanks",                  " \t \n",                "", NONE},
    {"7.3.1 separators alone",        ";; ;\n",                "", NONE},
    {"7.3.1 a separator at the end",  "*TST?;\n",              "0\n", NONE},
    {"7.3.1 a separator in front",    ";*TST?\n",              "0\n", NONE},
    {"7.5 ends with CR",              "*TST?\r",               "0\n", NONE},
    {"7.5 ends with CR LF",           "*TST?\r\n",             "0\n", NONE},
    {"7.5 lines have an answer each", "*TST?\n*TST?\n",        "0\n0\n", NONE},
    {"8.3 answers of a line",         "*TST?;*IDN?;*ESE?\n",   "0;drehgeber,rig,0,1.2.3;0\n", NONE},
    {"8.4 parts of an answer",        "PART? 12\n",
     "0.012,12,key=word,\"say \"\"yes\"\"\",piece0.000000000000000012000000000000000C\n", NONE},
    {"8.4 the longest numbers",       "PART? -9223372036854775808\n",
     "-9223372036854775.808,9223372036854775808,key=word,\"say \"\"yes\"\"\",piece-9.2233720368547758088000000000000000\n", NONE},
    {"8.4 an empty answer is one",    "NOTH?\n",               "\n", NONE},
    {"8.4 among others",              "*TST?;NOTH?;*TST?\n",   "0;;0\n", NONE},
    {"an error ends the line",        "*TST?;NO;*TST?\n*TST?\n", "0\n0\n", UNDEFINED("NO; SYSTem:HELP? has all")},
    {"one error a command",           "FAUL:SET x,COUN;*TST?\n", "",
     "-109,\"Missing parameter;FAULt:SET NAME[,COUNt n][,PROBability p][,DURation TIME]\"\n"},
    {"a handler may raise more",      "FAIL;*TST?\n",          "", "-240,\"Hardware error;first\",-250,\"Mass storage error\"\n"},
    {"nothing is put after an error", "*TST?;FAIL?;*TST?\n",   "0\n", "-240,\"Hardware error;first\",-250,\"Mass storage error\"\n"},
    {"-108 in front of the act",      "SHAF:VEL 1\nSHAF:VEL 2,3\nSHAF:VEL?\n", "1000\n", "-108,\"Parameter not allowed;SHAFt:VELocity SPEED\"\n"},
    {"-108 without parameters",       "*CLS 1;*TST?\n",        "", "-108,\"Parameter not allowed;*CLS\"\n"},
    {"-108 a comma is one, too",      "*CLS ,\n",              "", "-108,\"Parameter not allowed;*CLS\"\n"},
    {"-108 of a query, no answer",    "*TST? 1\n",             "", "-108,\"Parameter not allowed;*TST?\"\n"},
    {"-108 of a query with parameters", "PART? 1,2\n",         "", "-108,\"Parameter not allowed;PARTs? [N]\"\n"},
    {"-108 of *OPC?, no waiting",     "*OPC? 1\n",             "", "-108,\"Parameter not allowed;*OPC?\"\n"},
    {"-108 of *ESR?, nothing cleared", "*ESR? 1\n*ESR?\n",     "160\n", "-108,\"Parameter not allowed;*ESR?\"\n"},
    {"-108 of SYST:ERR?, none lost",  "NO\nSYST:ERR? 1\n",     "", "-113,\"Undefined header;NO; SYSTem:HELP? has all\",-108,\"Parameter not allowed;SYSTem:ERRor[:NEXT]?\"\n"},
    {"-108 of SYST:HELP?",            "SYST:HELP? SHAF\n",     "", "-108,\"Parameter not allowed;SYSTem:HELP[:HEADers]?\"\n"},
    {"-108 of an empty answer",       "NOTH? 1\n",             "", "-108,\"Parameter not allowed;NOTHing?\"\n"},
    {"-109 none",                     "SHAF:VEL\n",            "", "-109,\"Missing parameter;SHAFt:VELocity SPEED\"\n"},
    {"-109 in front of a comma",      "BYT ,1\n",              "", "-109,\"Missing parameter;BYTes N[,N]...\"\n"},
    {"-109 behind a comma",           "BYT 1,\n",              "", "-109,\"Missing parameter;BYTes N[,N]...\"\n"},
    {"-109 between commas",           "BYT 1,,2\n",            "", "-109,\"Missing parameter;BYTes N[,N]...\"\n"},
    {"-108 counts to the command's end", "BYTE 1;BYT 1,2,3;BYTE?\n", "3\n", NONE},
    {"any number of parameters",      "BYT 1,2, 3 ,4\t,5,6,7,8;BYTE?\n", "8\n", NONE},
};

static const struct row parameters[] = {
    {"7.7.5 double quotes",           "TEXT \"a b\";TEXT?\n",    "\"a b\"\n", NONE},
    {"7.7.5 single quotes",           "TEXT 'a b';TEXT?\n",      "\"a b\"\n", NONE},
    {"7.7.5 doubled double quotes",   "TEXT \"a\"\"b\";TEXT?\n", "\"a\"\"b\"\n", NONE},
    {"7.7.5 doubled single quotes",   "TEXT 'a''b';TEXT?\n",     "\"a'b\"\n", NONE},
    {"7.7.5 the other quotes",        "TEXT 'a\"b';TEXT?\n",     "\"a\"\"b\"\n", NONE},
    {"7.7.5 separators in a string",  "TEXT \"a;b,c\";TEXT?\n",  "\"a;b,c\"\n", NONE},
    {"7.7.5 a quote of the other kind does not end it", "TEXT \"a',b\";TEXT?\n", "\"a',b\"\n", NONE},
    {"7.7.5 the first and last characters", "TEXT '! ~';TEXT?\n", "\"! ~\"\n", NONE},
    {"7.7.5 nothing but a quote",     "TEXT \"\"\"\";TEXT?\n",   "\"\"\"\"\n", NONE},
    {"7.7.5 empty",                   "TEXT 'x';TEXT '';TEXT?\n", "\"\"\n", NONE},
    {"7.7.5 15 characters fit 16",    "TEXT '123456789012345';TEXT?\n", "\"123456789012345\"\n", NONE},
    {"-222 16 do not",                "TEXT '1234567890123456';TEXT?\n", "", "-222,\"Data out of range;at most 15 characters\"\n"},
    {"-151 not closed",               "TEXT \"a;TEXT?\n",        "", "-151,\"Invalid string data;no closing quote\"\n"},
    {"-151 not closed, only opened",  "TEXT '\n",                "", "-151,\"Invalid string data;no closing quote\"\n"},
    {"-151 the quote was a character", "TEXT 'a''\n",            "", "-151,\"Invalid string data;no closing quote\"\n"},
    {"-151 more behind it",           "TEXT 'a'b\n",             "", "-151,\"Invalid string data;b\"\n"},
    {"-102 more behind a blank",      "TEXT 'a' b\n",            "", "-102,\"Syntax error;b; expected TEXT \"\"TEXT\"\"\"\n"},
    {"-102 a comma is missing",       "FAUL:SET x DUR 5S\n",     "", "-102,\"Syntax error;DUR; a comma is missing, expected FAULt:SET NAME[,COUNt n][,PROBability p][,DURation TIME]\"\n"},
    {"-102 behind a number, too",     "BYT 1 2\n",              "", "-102,\"Syntax error;2; a comma is missing, expected BYTes N[,N]...\"\n"},
    {"-102 behind a bare text",       "TEXT a b\n",              "", "-102,\"Syntax error;b; expected TEXT \"\"TEXT\"\"\"\n"},
    {"7.7.1 bare characters",         "TEXT a-b/c.d;TEXT?\n",    "\"a-b/c.d\"\n", NONE},
    {"7.7.1 quotes within",           "TEXT it's;TEXT?\n",       "\"it's\"\n", NONE},
    {"-222 bare, too long",           "TEXT 1234567890123456\n", "", "-222,\"Data out of range;at most 15 characters\"\n"},
    {"-109 no text",                  "TEXT\n",                  "", "-109,\"Missing parameter;TEXT \"\"TEXT\"\"\"\n"},
    {"7.7.1 words, long and short",   "FAUL:SET x,COUNT 3,prob 0.5;NUMB?;VAL?\n", "", UNDEFINED("FAUL:NUMB?; closest is NUMBer?")},
    {"7.7.1 words and numbers",       "FAUL:SET x,COUNT 3,prob 0.5,duration 2 S;:NUMB?;VAL?;TIME:STEP?\n", "3;0.500;2000000000\n", NONE},
    {"7.7.1 a comma behind a word",   "FAUL:SET x,COUN,3;:NUMB?\n", "3\n", NONE},
    {"-224 no word of these",         "FAUL:SET x,COUNTS 3\n",   "", "-224,\"Illegal parameter value;COUNTS; expected COUNt, PROBability or DURation\"\n"},
    {"-224 no number",                "FAUL:SET x,3\n",          "", "-224,\"Illegal parameter value;3; expected COUNt, PROBability or DURation\"\n"},
    {"-224 no string",                "FAUL:SET x,\"COUN\" 3\n", "", "-224,\"Illegal parameter value;\"\"COUN\"\"; expected COUNt, PROBability or DURation\"\n"},
    {"-224 a word to its end",        "FAUL:SET x,COUN3\n",      "", "-224,\"Illegal parameter value;COUN3; expected COUNt, PROBability or DURation\"\n"},
    {"-108 behind the last word",     "FAUL:SET x,COUN 1,PROB 0,DUR 1,COUN 1;:TEXT?\n", "",
     "-108,\"Parameter not allowed;FAULt:SET NAME[,COUNt n][,PROBability p][,DURation TIME]\"\n"},
    {"7.7.6 ON and 1",                "FLAG ON;FLAG?;FLAG off;FLAG?;FLAG 1;FLAG?;FLAG 0;FLAG?\n", "1;0;1;0\n", NONE},
    {"-224 no flag",                  "FLAG YES\n",              "", "-224,\"Illegal parameter value;YES; expected OFF, ON, 0 or 1\"\n"},
    {"-224 no flag, either",          "FLAG 2\n",                "", "-224,\"Illegal parameter value;2; expected OFF, ON, 0 or 1\"\n"},
    {"-109 no flag at all",           "FLAG \n",                 "", "-109,\"Missing parameter;FLAG ON|OFF\"\n"},
    {"-102 more behind a flag",       "FLAG ON OFF;FLAG?\n",     "", "-102,\"Syntax error;OFF; expected FLAG ON|OFF\"\n"},
};
/* clang-format on */

static void headers_are_found(void **state)
{
    (void)state;
    check_all(headers, DG_COUNT(headers));
}

static void relative_headers_follow_the_path(void **state)
{
    (void)state;
    check_all(paths, DG_COUNT(paths));
}

static void lines_have_one_answer(void **state)
{
    (void)state;
    check_all(messages, DG_COUNT(messages));
}

static void words_and_strings_are_read(void **state)
{
    (void)state;
    check_all(parameters, DG_COUNT(parameters));
}

/* Strings of any length, quoted or not: none is written beyond its place, which is the rig's text,
 * or said to be taken when it does not fit. */
static void strings_stay_in_their_place(void **state)
{
    static const char *const quotes[] = {"", "'", "\""};
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz";
    const dg_ns mark = UINT64_MAX / 3u;
    (void)state;

    for (size_t quote = 0; quote < DG_COUNT(quotes); quote++) {
        for (int n = 1; n <= 26; n++) {
            char line[64];
            scpi_rig_init(&rig);
            rig.settles = mark; /* right behind it */
            (void)snprintf(line, sizeof line, "TEXT %s%.*s%s\n", quotes[quote], n, letters,
                           quotes[quote]);
            scpi_rig_send(&rig, line);
            assert_true(rig.settles == mark);
            assert_int_equal(rig.taken, n < (int)SCPI_RIG_TEXT_SIZE ? 1 : 0);
            assert_int_equal(rig.session.error_count, n < (int)SCPI_RIG_TEXT_SIZE ? 0 : 1);
            assert_int_equal(strlen(rig.text), n < (int)SCPI_RIG_TEXT_SIZE ? n : 15);
            assert_memory_equal(rig.text, letters, strlen(rig.text));
        }
    }
}

/* What is refused is not said to be taken. */
static void refusals_are_told(void **state)
{
    static const char *const lines[] = {
        "TEXT\n", "TEXT 'a\n", "TEXT 'a'b\n", "TEXT a b\n", "FLAG\n", "FLAG YES\n", "FLAG ON OFF\n",
    };
    (void)state;

    for (size_t i = 0; i < DG_COUNT(lines); i++) {
        scpi_rig_init(&rig);
        scpi_rig_send(&rig, lines[i]);
        assert_int_equal(rig.taken, 0);
        assert_int_equal(rig.session.error_count, 1);
    }
}

static void only_letters_have_two_forms(void **state)
{
    (void)state;
    for (int c = 0; c < 128; c++) {
        const bool small = strchr("abcdefghijklmnopqrstuvwxyz", c) != NULL && c != 0;
        assert_int_equal(dg_text_upper((char)c), small ? c - 32 : c);
    }
}

/* A path that grows with each command never overtakes what is still to be read. */
static void the_longest_line_is_read(void **state)
{
    static const char piece[] = ";SUPP 5";
    char line[DG_SCPI_LINE_MAX + 2u] = "WORL:SUPP 5";
    (void)state;

    while (strlen(line) + sizeof piece + sizeof ";SUPP?" < DG_SCPI_LINE_MAX) {
        strcat(line, piece);
    }
    strcat(line, ";SUPP?");
    memset(&line[strlen(line)], ' ', DG_SCPI_LINE_MAX - strlen(line));
    line[DG_SCPI_LINE_MAX] = '\n';
    line[DG_SCPI_LINE_MAX + 1u] = '\0';
    check(&(struct row){"longest line", line, "5\n", NONE});
}

static void a_longer_line_is_one_error(void **state)
{
    char line[3u * DG_SCPI_LINE_MAX];
    (void)state;

    for (size_t n = DG_SCPI_LINE_MAX + 1u; n < sizeof line - 8u; n += 97) {
        memset(line, ';', n);
        memcpy(line, "*TST?;\x80", 7);
        (void)snprintf(&line[n], 8, "\n*TST?\n");
        check(&(struct row){"overlong", line, "0\n", "-363,\"Input buffer overrun\"\n"});
    }
}

/* Every byte that is no text, in every place of a line. */
static void garbage_is_one_error(void **state)
{
    static const char good[] = "*TST?;*IDN?\n";
    (void)state;

    for (unsigned byte = 0; byte < 256; byte++) {
        const bool text = (byte >= ' ' && byte <= '~') || byte == '\t';
        for (size_t at = 0; !text && byte != '\n' && byte != '\r' && at + 1 < sizeof good - 1u;
             at++) {
            char line[sizeof good];
            memcpy(line, good, sizeof good);
            line[at] = (char)byte;
            scpi_rig_init(&rig);
            scpi_rig_send_bytes(&rig, line, sizeof line - 1u);
            assert_string_equal(rig.out, "");
            scpi_rig_send(&rig, "SYST:ERR:ALL?;*TST?\n");
            assert_string_equal(rig.out, "-113,\"Undefined header;not printable ASCII\";0\n");
        }
    }
}

/* The help has a line for each command and query there is, which can be sent as it stands. */
static void help_lists_all(void **state)
{
    unsigned expected = 0;
    unsigned lines = 0;
    (void)state;

    for (size_t i = 0; i < scpi_rig_command_count; i++) {
        expected += scpi_rig_commands[i].set != NULL ? 1u : 0u;
        expected += scpi_rig_commands[i].query != NULL ? 1u : 0u;
    }
    for (size_t i = 0; i < dg_scpi_own.count; i++) {
        expected += dg_scpi_own.rows[i].set != NULL ? 1u : 0u;
        expected += dg_scpi_own.rows[i].query != NULL ? 1u : 0u;
    }
    scpi_rig_init(&rig);
    scpi_rig_send(&rig, "SYST:HELP:HEAD?\n");
    assert_non_null(strstr(rig.out, "\"*CLS\",\"*ESE MASK\",\"*ESE?\",\"*ESR?\""));
    assert_non_null(strstr(rig.out, ",\"SYSTem:ERRor[:NEXT]?\","));
    assert_non_null(strstr(rig.out, ",\"SHAFt:POSition ANGLE\",\"SHAFt:POSition?\","));
    assert_non_null(strstr(rig.out, ",\"SHAFt:STOP\",\"TIME:STEP TIME\","));
    assert_non_null(strstr(rig.out, ",\"TEXT \"\"TEXT\"\"\",\"TEXT?\","));
    assert_non_null(strstr(rig.out, ",\"PARTs? [N]\","));
    for (const char *at = rig.out; at != NULL; at = strstr(at + 1, "\",\"")) {
        lines++;
    }
    assert_int_equal(lines, expected);
    assert_string_equal(&rig.out[rig.length - 2u], "\"\n");
    char first[SCPI_RIG_OUT_MAX];
    memcpy(first, rig.out, sizeof first);
    scpi_rig_send(&rig, "SYST:HELP?\n");
    assert_string_equal(rig.out, first);
}

/* No row hides another one, and every row can be found under its own name. */
static void tables_are_sound(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    for (size_t i = 0; i < dg_scpi_own.count; i++) {
        const struct dg_scpi_command *row = &dg_scpi_own.rows[i];
        assert_true(row->set != NULL || row->query != NULL);
        assert_true(strlen(row->help) > 0);
        for (size_t j = 0; j < dg_scpi_own.count; j++) {
            assert_true(i == j || strcmp(row->header, dg_scpi_own.rows[j].header) != 0);
        }
    }
    assert_ptr_equal(dg_scpi_find(&rig.session, "*cls", 4, false), &dg_scpi_own.rows[0]);
    assert_null(dg_scpi_find(&rig.session, "*cls", 4, true));
}

/* A handler may make the host step its own session: the command at hand is not begun again. */
static void a_handler_does_not_recurse(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    scpi_rig_send(&rig, "SHAF:STOP;STOP;:BYTE 7;BYTE?\n");
    assert_string_equal(rig.out, "7\n");
    assert_int_equal(rig.stops, 2);
}

/* Two sessions know nothing of each other. */
static void sessions_are_apart(void **state)
{
    static struct scpi_rig other;
    (void)state;

    scpi_rig_init(&rig);
    scpi_rig_init(&other);
    scpi_rig_send(&rig, "SHAF:VEL 1;NO");
    scpi_rig_send(&other, "VEL 2\n");
    scpi_rig_send(&rig, "\nSYST:ERR?\n");
    assert_string_equal(rig.out, UNDEFINED("SHAF:NO; SYSTem:HELP? has all"));
    scpi_rig_send(&other, "SYST:ERR?\n");
    assert_string_equal(other.out, UNDEFINED("VEL; closest is SHAFt:VELocity SPEED"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(headers_are_found),
        cmocka_unit_test(relative_headers_follow_the_path),
        cmocka_unit_test(lines_have_one_answer),
        cmocka_unit_test(words_and_strings_are_read),
        cmocka_unit_test(strings_stay_in_their_place),
        cmocka_unit_test(refusals_are_told),
        cmocka_unit_test(only_letters_have_two_forms),
        cmocka_unit_test(the_longest_line_is_read),
        cmocka_unit_test(a_longer_line_is_one_error),
        cmocka_unit_test(garbage_is_one_error),
        cmocka_unit_test(help_lists_all),
        cmocka_unit_test(tables_are_sound),
        cmocka_unit_test(a_handler_does_not_recurse),
        cmocka_unit_test(sessions_are_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
