// SPDX-License-Identifier: MIT
// What people read is plain technical English. textlint looks for the words that words/dictionary.yml replaces, for the spelling
// of terms, for wordy phrases, and for sentences that are too long or are chains. Code, generated tables and the sections of
// releases in the changelog are not checked.
//
// usage: words.mjs TREE PACKAGES [--help-texts PROGRAM | PAGE...]
//        PACKAGES has in node_modules what words/package-lock.json pins. PAGE is a part of a page's path: only such pages are
//        checked. --help-texts checks the words of what PROGRAM prints with --help, and of the manual pages, in place of pages.
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const DICTIONARY = fileURLToPath(new URL("words/dictionary.yml", import.meta.url));
const IGNORED = new Set([".git", "build", ".cache", "__pycache__", "node_modules"]);
const LONGEST_SENTENCE = 32; // words
const MOST_SEMICOLONS = 1; // in a sentence
// A program writes these parts of a page.
const GENERATED = /<!-- (?:generated|green|screen)\b[^]*?<!-- end -->/g;
const RELEASED = /^## \d+\.\d+\.\d+ [^]*/m;
// What terminology and write-good would replace, and is in order here.
const OTHER_TERMS = ["command ?line", "run[- ]time", "built ?in(s)?", "build system(s)?", "file[- ]name(s)?"];
const OTHER_PHRASES = new Set(["initial", "minimum", "maximum", "multiple", "transmit", "address", "monitor", "parameters",
    "terminate", "equivalent", "function", "component", "combined", "interface", "submit", "request", "evaluate", "indicate",
    "option", "type", "implement", "remain", "remains", "previously", "previous", "subsequent", "additional", "it is", "it was",
    "all of", "however", "therefore", "in between", "in a word"]);

function findPages(tree, folder = tree) {
    return readdirSync(folder, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1)).flatMap((entry) => {
        const path = join(folder, entry.name);
        if (entry.isDirectory()) return IGNORED.has(entry.name) ? [] : findPages(tree, path);
        return entry.name.endsWith(".md") && entry.isFile() ? [relative(tree, path)] : [];
    });
}

/** The text with what is not checked blanked; lines keep their numbers. */
function blankUnchecked(path, text) {
    const patterns = path.endsWith("CHANGELOG.md") ? [GENERATED, RELEASED] : [GENERATED];
    return patterns.reduce((left, pattern) => left.replace(pattern, (part) => part.replace(/[^\n]+/g, "")), text);
}

/** A rule of textlint: how long a sentence is, how many semicolons join its parts, and whether its subject is a thing or an actor. */
function judgeSentences({ Syntax, RuleError, getSource, report }) {
    function judge(node) {
        const source = getSource(node).replace(/`[^`]*`/g, (code) => "x".repeat(code.length))
            .replace(/\]\([^)]*\)/g, (link) => "]".padEnd(link.length));
        for (const { 0: sentence, index } of source.matchAll(/[^.!?:]+(?:[.!?:](?![*"')\]]*(?:\s|$))[^.!?:]*)*/g)) {
            const words = sentence.split(/\s+/).filter((word) => /\w/.test(word)).length;
            const semicolons = sentence.split(";").length - 1;
            if (words > LONGEST_SENTENCE) report(node, new RuleError(`a sentence of ${words} words`, { index }));
            if (semicolons > MOST_SEMICOLONS) report(node, new RuleError(`a chain of ${semicolons} semicolons`, { index }));
            if (/^[\s*"]*Wh(?:at|o)\s/.test(sentence) && source[index + sentence.length] === ".") {
                report(node, new RuleError("a clause with what or who as its subject: name the thing or the actor", { index }));
            }
        }
    }
    return { [Syntax.Paragraph]: judge };
}

function loadLinter(packages) {
    const require = createRequire(resolve(packages, "package.json"));
    const load = (name) => require(name).default ?? require(name);
    const { TextlintKernel } = require("@textlint/kernel");
    return {
        kernel: new TextlintKernel(),
        plugins: [{ pluginId: "markdown", plugin: load("@textlint/textlint-plugin-markdown") }],
        rules: [
            { ruleId: "words", rule: load("textlint-rule-prh"),
              options: { rulePaths: [DICTIONARY], checkLink: true, checkEmphasis: true, checkBlockQuote: true } },
            { ruleId: "terms", rule: load("textlint-rule-terminology"), options: { exclude: OTHER_TERMS } },
            { ruleId: "wordy", rule: load("textlint-rule-write-good"), options: { passive: false, weasel: false, adverb: false,
                so: false, thereIs: false } },
            { ruleId: "sentence", rule: judgeSentences, options: {} },
        ],
    };
}

async function lintText({ kernel, plugins, rules }, path, text) {
    const { messages } = await kernel.lintText(text, { filePath: path, ext: ".md", plugins, rules });
    const phrase = (message) => message.match(/^"([^"]*)"/)?.[1].toLowerCase().replace(/\s+/g, " ");
    const inOrder = ({ ruleId, message }) => ruleId === "wordy" && OTHER_PHRASES.has(phrase(message));
    return messages.filter((one) => !inOrder(one)).map((one) => `${path}:${one.line}: ${one.ruleId}: ${one.message.replaceAll("\n", " ")}`);
}

async function judgePages(linter, tree, wanted) {
    const pages = findPages(tree).filter((path) => !wanted.length || wanted.some((part) => path.includes(part)));
    const complaints = [];
    for (const path of pages) {
        complaints.push(...await lintText(linter, path, blankUnchecked(path, readFileSync(join(tree, path), "utf8"))));
    }
    return [pages.length, complaints];
}

/** Words only: columns are neither sentences nor Markdown. */
async function judgeHelp(linter, tree, program) {
    const print = (...words) => execFileSync(program, words, { encoding: "utf8" });
    const commands = readdirSync(join(tree, "tools/man")).flatMap((name) => name.match(/^drehgeber-(\w+)\.1$/)?.[1] ?? []);
    const texts = [["--help", print("--help")], ...commands.map((name) => [`${name} --help`, print(name, "--help")]),
        ...readdirSync(join(tree, "tools/man")).map((name) => [`tools/man/${name}`, readFileSync(join(tree, "tools/man", name), "utf8")])];
    const words = { ...linter, rules: linter.rules.filter(({ ruleId }) => ruleId === "words") };
    const complaints = [];
    for (const [name, text] of texts) {
        complaints.push(...await lintText(words, name, text.replace(/^[ .>+-]+/gm, "").replace(/[`*_#<>|\\[\]]/g, " ")));
    }
    return [texts.length, complaints];
}

const [tree, packages, ...wanted] = process.argv.slice(2);
const linter = loadLinter(packages);
const [checked, complaints] = wanted[0] === "--help-texts" ? await judgeHelp(linter, tree, wanted[1])
    : await judgePages(linter, tree, wanted);
for (const complaint of complaints) console.log(complaint);
console.log(`${checked} checked, ${complaints.length} complaints`);
process.exitCode = complaints.length || !checked ? 1 : 0;
