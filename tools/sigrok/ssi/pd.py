# SPDX-License-Identifier: MIT
'''
OUTPUT_PYTHON: [TYPE, DATA]
 - 'WORD': (MT, ST, error, parity right) of a word; error and parity are None where there is no such bit.
 - 'REPEAT': whether the word that was clocked once more is the same.
'''
from bisect import bisect_right

import sigrokdecode as srd

CLOCK, DATA = 0, 1

ANNOTATIONS = (
    ('position', 'Position bits'),
    ('error', 'Error bit'),
    ('parity', 'Parity bit'),
    ('stop', 'Behind the word'),
    ('monoflop', 'Monoflop time'),
    ('word', 'Word'),
    ('repeat', 'Repeated word'),
    ('warning', 'Warning'),
)
CLASS = {name: number for number, (name, _) in enumerate(ANNOTATIONS)}


def number(bits):
    value = 0
    for bit in bits:
        value = value << 1 | bit
    return value


def from_gray(value):
    shift = 1
    while value >> shift:
        value ^= value >> shift
        shift *= 2
    return value


class SamplerateError(Exception):
    pass


class Decoder(srd.Decoder):
    api_version = 3
    id = 'ssi'
    name = 'SSI'
    longname = 'Synchronous serial interface of encoders'
    desc = 'Absolute encoders: position, error bit, parity.'
    license = 'mit'
    inputs = ['logic']
    outputs = ['ssi']
    tags = ['Embedded/industrial', 'Sensor']
    channels = (
        {'id': 'clock', 'name': 'CLOCK', 'desc': 'Clock of the master'},
        {'id': 'data', 'name': 'DATA', 'desc': 'Data of the encoder'},
    )
    options = (
        {'id': 'mt', 'desc': 'Multiturn bits', 'default': 12},
        {'id': 'st', 'desc': 'Singleturn bits', 'default': 13},
        {'id': 'code', 'desc': 'Code of the position', 'default': 'gray', 'values': ('gray', 'binary')},
        {'id': 'error_bit', 'desc': 'Error bit, its level', 'default': 'none', 'values': ('none', 'high', 'low')},
        {'id': 'parity', 'desc': 'Parity bit', 'default': 'none', 'values': ('none', 'even', 'odd')},
        {'id': 'monoflop_ns', 'desc': 'Monoflop time (ns)', 'default': 20000},
    )
    annotations = ANNOTATIONS
    annotation_rows = (
        ('fields', 'Fields', tuple(range(CLASS['position'], CLASS['monoflop'] + 1))),
        ('words', 'Words', (CLASS['word'], CLASS['repeat'])),
        ('warnings', 'Warnings', (CLASS['warning'],)),
    )
    binary = (
        ('words', 'Words, MSB first, in whole bytes'),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.out_python = self.register(srd.OUTPUT_PYTHON)
        self.out_binary = self.register(srd.OUTPUT_BINARY)
        self.position_bits = self.options['mt'] + self.options['st']
        self.error_bits = int(self.options['error_bit'] != 'none')
        self.parity_bits = int(self.options['parity'] != 'none')
        self.word_bits = self.position_bits + self.error_bits + self.parity_bits

    def ann(self, ss, es, name, *texts):
        self.put(ss, es, self.out_ann, [CLASS[name], list(texts)])

    def warn(self, ss, es, text):
        self.ann(ss, es, 'warning', text)

    # --- edges ---

    def decode(self):
        if not self.samplerate:
            raise SamplerateError('Cannot decode without samplerate.')
        self.monoflop = max(1, self.options['monoflop_ns'] * self.samplerate // 10**9)
        _, data = self.wait({CLOCK: 'f'})
        while True:
            # This edge stores the position.
            data = self.collect(data)
            self.tell()
            again = False
            if not data:
                _, data = self.wait([{DATA: 'r'}, {CLOCK: 'f'}])
                again = self.matched[1]
                if not again:
                    self.tell_monoflop(self.samplenum)
            if not again:
                _, data = self.wait({CLOCK: 'f'})

    def collect(self, data):
        '''Edges until the monoflop time is over. Returns the level of the data then.'''
        self.falling, self.rising = [self.samplenum], []
        self.changed, self.levels = [self.samplenum], [data]
        clock = 0
        while True:
            end = self.falling[-1] + self.monoflop
            before = clock
            clock, data = self.wait([{CLOCK: 'e'}, {DATA: 'e'}, {'skip': end - self.samplenum}])
            if data != self.levels[-1]:
                self.changed.append(self.samplenum)
                self.levels.append(data)
            if self.samplenum >= end:
                return data
            if clock != before:
                (self.rising if clock else self.falling).append(self.samplenum)

    def level_at(self, sample):
        return self.levels[bisect_right(self.changed, sample) - 1]

    # --- words ---

    def tell(self):
        '''A bit begins with a rising edge and is taken as late as can be, at the next falling one.'''
        rising, falling = self.rising, self.falling
        self.ends = falling[1:] if len(falling) > len(rising) else falling[1:] + [2 * rising[-1] - falling[-1]]
        bits = [self.level_at(sample) for sample in self.ends]
        # Where a bit is shown: up to the next rising edge.
        self.edges = rising + self.ends[-1:]
        if not self.levels[0]:
            self.warn(falling[0], self.ends[-1] if bits else self.samplenum, 'data low at rest: no supply, or not ready')
        if len(bits) < self.word_bits:
            self.warn(falling[0], self.samplenum, 'cut: %d of %d bits' % (len(bits), self.word_bits))
            return
        word = bits[:self.word_bits]
        self.fields(word)
        at = self.word_bits
        while at < len(bits):
            at = self.behind(bits, word, at)
        quiet = max(rising[-1], falling[-1])
        rises = [sample for sample, level in zip(self.changed, self.levels) if level and sample > quiet]
        if rises:
            self.tell_monoflop(rises[0])

    def tell_monoflop(self, sample):
        us = (sample - self.falling[-1]) * 1e6 / self.samplerate
        self.ann(self.falling[-1], sample, 'monoflop', 'Monoflop %.1f us' % us, 'tm')

    def fields(self, bits):
        edges, n = self.edges, self.position_bits
        es = edges[self.word_bits]
        position = from_gray(number(bits[:n])) if self.options['code'] == 'gray' else number(bits[:n])
        mt, st = position >> self.options['st'], position & (1 << self.options['st']) - 1
        words = ['MT %d' % mt] if self.options['mt'] else []
        words.append('ST %d' % st)
        self.ann(edges[0], edges[n], 'position', ' '.join(words), 'ST %d' % st)
        error = right = None
        if self.error_bits:
            error = int(bits[n] == (self.options['error_bit'] == 'high'))
            self.ann(edges[n], edges[n + 1], 'error', 'Error %d' % error, str(error))
            words.append('error %d' % error)
        if self.parity_bits:
            right = sum(bits) % 2 == int(self.options['parity'] == 'odd')
            words.append('parity ' + ('ok' if right else 'wrong'))
            self.ann(edges[self.word_bits - 1], es, 'parity', 'P' + words[-1][1:], str(bits[-1]))
            if not right:
                self.warn(edges[self.word_bits - 1], es, 'parity wrong')
        self.ann(edges[0], es, 'word', ' '.join(words), 'ST %d' % st)
        self.put(edges[0], es, self.out_python, ['WORD', (mt, st, error, right)])
        self.put(edges[0], es, self.out_binary, [0, number(bits).to_bytes(-(-self.word_bits // 8), 'big')])

    def behind(self, bits, word, at):
        '''A 0, and the word once more or zeros. Returns what is behind that.'''
        edges = self.edges
        self.ann(edges[at], edges[at + 1], 'stop', '%d behind the word' % bits[at], str(bits[at]))
        if bits[at]:
            self.warn(edges[at], edges[at + 1], '1 behind the word: a wider one, or an error')
        begin, end = at + 1, at + 1 + self.word_bits
        again = bits[begin:end]
        if len(again) == self.word_bits and any(again):
            same = again == word
            self.ann(edges[begin], edges[end], 'repeat', 'repeated' if same else 'repeated, not the same', 'R')
            if not same:
                self.warn(edges[begin], edges[end], 'the repeated word is not the same')
            self.put(edges[begin], edges[end], self.out_python, ['REPEAT', same])
        elif any(again):
            self.warn(edges[begin], edges[-1], 'repeated word cut: %d of %d bits' % (len(again), self.word_bits))
        return end
