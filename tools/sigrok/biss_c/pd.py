# SPDX-License-Identifier: MIT
'''
OUTPUT_PYTHON: [TYPE, DATA]
 - 'DATA': of a frame whose data is whole, for each slave (MT, ST, nERR, nWARN, LC, CRC right), the one
   next to the master first; without life counter LC is None.
 - 'CONTROL': of every frame of two clocks or more, (CDM, CDS); CDS is None where it was not sent.
'''
from bisect import bisect_right

import sigrokdecode as srd

MA, SLO = 0, 1
CRC_BITS = 6
CRC_POLYNOMIAL = 0x43

ANNOTATIONS = (
    ('ack', 'Ack'),
    ('start', 'Start bit'),
    ('cds', 'CDS'),
    ('mt', 'Multiturn'),
    ('st', 'Singleturn'),
    ('nerr', 'nERR'),
    ('nwarn', 'nWARN'),
    ('lc', 'Life counter'),
    ('crc', 'CRC'),
    ('stop', 'Stop'),
    ('timeout', 'Timeout'),
    ('cdm', 'CDM'),
    ('position', 'Position'),
    ('warning', 'Warning'),
)
CLASS = {name: number for number, (name, _) in enumerate(ANNOTATIONS)}


def crc6(bits):
    '''Inverted, as it is sent.'''
    value = 0
    for bit in bits:
        value = value << 1 ^ bit << CRC_BITS
        value ^= CRC_POLYNOMIAL if value >> CRC_BITS & 1 else 0
    return value ^ (1 << CRC_BITS) - 1


def number(bits):
    value = 0
    for bit in bits:
        value = value << 1 | bit
    return value


class SamplerateError(Exception):
    pass


class Decoder(srd.Decoder):
    api_version = 3
    id = 'biss_c'
    name = 'BiSS-C'
    longname = 'BiSS-C, bidirectional serial synchronous'
    desc = 'Absolute encoders: position, flags, control bits.'
    license = 'mit'
    inputs = ['logic']
    outputs = ['biss_c']
    tags = ['Embedded/industrial', 'Sensor']
    channels = (
        {'id': 'ma', 'name': 'MA', 'desc': 'Clock of the master'},
        {'id': 'slo', 'name': 'SLO', 'desc': 'Data of the slaves'},
    )
    options = (
        {'id': 'mt', 'desc': 'Multiturn bits', 'default': 12},
        {'id': 'st', 'desc': 'Singleturn bits', 'default': 21},
        {'id': 'lc', 'desc': 'Life counter', 'default': 'yes', 'values': ('yes', 'no')},
        {'id': 'slaves', 'desc': 'Slaves', 'default': 1, 'values': (1, 2, 3)},
        {'id': 'mt2', 'desc': 'Multiturn bits, 2nd slave', 'default': 12},
        {'id': 'st2', 'desc': 'Singleturn bits, 2nd slave', 'default': 21},
        {'id': 'lc2', 'desc': 'Life counter, 2nd slave', 'default': 'yes', 'values': ('yes', 'no')},
        {'id': 'mt3', 'desc': 'Multiturn bits, 3rd slave', 'default': 12},
        {'id': 'st3', 'desc': 'Singleturn bits, 3rd slave', 'default': 21},
        {'id': 'lc3', 'desc': 'Life counter, 3rd slave', 'default': 'yes', 'values': ('yes', 'no')},
        {'id': 'timeout_ns', 'desc': 'Silence of MA that ends a frame (ns)', 'default': 12000},
    )
    annotations = ANNOTATIONS
    annotation_rows = (
        ('fields', 'Fields', tuple(range(CLASS['ack'], CLASS['timeout'] + 1))),
        ('cdms', 'CDM', (CLASS['cdm'],)),
        ('positions', 'Positions', (CLASS['position'],)),
        ('warnings', 'Warnings', (CLASS['warning'],)),
    )
    binary = (
        ('data', 'Data of each slave with its CRC, MSB first, in whole bytes'),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None
        self.begin_frame()
        # Changes of SLO in this frame: samples, and the levels behind them.
        self.changed, self.levels = [0], [1]

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.out_python = self.register(srd.OUTPUT_PYTHON)
        self.out_binary = self.register(srd.OUTPUT_BINARY)
        self.slaves = []
        for suffix in ('', '2', '3')[:self.options['slaves']]:
            lc_bits = 6 if self.options['lc' + suffix] == 'yes' else 0
            self.slaves.append((
                ('mt', 'MT', self.options['mt' + suffix]),
                ('st', 'ST', self.options['st' + suffix]),
                ('nerr', 'nERR', 1),
                ('nwarn', 'nWARN', 1),
                ('lc', 'LC', lc_bits),
            ))

    def ann(self, ss, es, name, *texts):
        self.put(ss, es, self.out_ann, [CLASS[name], list(texts)])

    def warn(self, ss, es, text):
        self.ann(ss, es, 'warning', text)

    # --- edges ---

    def begin_frame(self):
        self.rising = []   # samples of the rising edges of MA: e1, e2, ...
        self.last = None   # the last edge of MA, unless the timeout is over

    def decode(self):
        if not self.samplerate:
            raise SamplerateError('Cannot decode without samplerate.')
        timeout = max(1, self.options['timeout_ns'] * self.samplerate // 10**9)
        ma, slo = self.wait()
        self.changed, self.levels = [self.samplenum], [slo]
        # The return of MA from a CDM = 1, or a clock that was low all the time, is no latch edge.
        returning = not ma
        while True:
            before = ma
            conditions = [{MA: 'e'}, {SLO: 'e'}]
            if self.last is not None:
                conditions.append({'skip': self.last + timeout - self.samplenum})
            ma, slo = self.wait(conditions)
            if self.last is not None and self.samplenum >= self.last + timeout:
                # An edge right at the end is the next frame's.
                returning = not before
                self.end_frame(before)
            if self.last is None:
                self.changed, self.levels = [self.samplenum], [slo]
            elif slo != self.levels[-1]:
                self.changed.append(self.samplenum)
                self.levels.append(slo)
            if ma == before:
                continue
            if returning:
                returning = not ma
                continue
            self.last = self.samplenum
            if ma:
                self.rising.append(self.samplenum)

    def end_frame(self, ma):
        if len(self.rising) == 1:
            self.warn(self.rising[0], self.samplenum, '1 clock is no frame')
        elif self.rising:
            self.frame(int(not ma))
        self.begin_frame()

    # --- frames ---

    def slo_at(self, sample):
        place = bisect_right(self.changed, sample) - 1
        return self.levels[max(place, 0)]

    def ack(self):
        '''The sample at which SLO falls for Ack: not before e2, the cable's delay behind it.'''
        for sample, level in zip(self.changed, self.levels):
            if sample >= self.rising[1] and not level:
                return sample
        return None

    def frame(self, cdm):
        '''A frame whose timeout is over now.'''
        self.ss, self.es = self.rising[0], self.samplenum
        cds = self.answer()
        self.ann(self.last, self.es, 'timeout', 'Timeout', 'T')
        self.ann(self.last, self.es, 'cdm', 'CDM %d' % cdm, str(cdm))
        self.put(self.ss, self.es, self.out_python, ['CONTROL', (cdm, cds)])

    def answer(self):
        '''What the slaves have sent. Returns CDS, or None.'''
        ack = self.ack()
        if ack is None:
            level = 'high' if self.slo_at(self.es) else 'low'
            self.warn(self.ss, self.es, 'no Ack: SLO stays %s' % level)
            return None
        # Bit k is there from the delay behind its edge to the delay behind the next one, and sampled
        # half way. The last one has no next edge and is taken to be as long as the one before.
        delay = ack - self.rising[1]
        edges = self.rising + [2 * self.rising[-1] - self.rising[-2]]
        self.edges = [edge + delay for edge in edges]
        bits = [self.slo_at((self.edges[k] + self.edges[k + 1]) // 2) for k in range(len(self.rising))
                if (self.edges[k] + self.edges[k + 1]) // 2 <= self.es]
        start = next((k for k in range(2, len(bits)) if bits[k]), None)
        if start is None:
            clocks = len(bits)
            self.ann(self.edges[1], self.edges[clocks], 'ack', 'Ack', 'A')
            if clocks > 2:
                self.warn(self.ss, self.es, 'no start bit in %d clocks' % clocks)
            return None
        self.ann(self.edges[1], self.edges[start], 'ack', 'Ack', 'A')
        self.ann(self.edges[start], self.edges[start + 1], 'start', 'Start', 'S')
        if start + 1 == len(bits):
            self.warn(self.ss, self.es, 'cut: no CDS')
            return None
        cds = bits[start + 1]
        self.ann(self.edges[start + 1], self.edges[start + 2], 'cds', 'CDS %d' % cds, str(cds))
        self.data(bits, start + 2)
        return cds

    def data(self, bits, at):
        '''Data of all slaves, and what is behind it.'''
        wanted = sum(CRC_BITS + sum(n for _, _, n in fields) for fields in self.slaves)
        if len(bits) - at < wanted:
            self.warn(self.ss, self.es, 'cut: %d of %d data bits' % (len(bits) - at, wanted))
            return
        if not any(bits[at:at + wanted]):
            # A CRC is inverted: no data has only zeros.
            self.ann(self.edges[at], self.edges[at + wanted], 'stop', 'No data', '-')
            return
        told = []
        for place, fields in enumerate(self.slaves):
            found, at = self.slave(bits, at, fields, place)
            told.append(found)
        if at < len(bits):
            self.ann(self.edges[at], self.edges[len(bits)], 'stop', 'Stop', 'P')
            if any(bits[at:]):
                self.warn(self.edges[at], self.edges[len(bits)], '1 behind the CRC: more slaves, or wider data?')
        self.put(self.ss, self.es, self.out_python, ['DATA', told])

    def slave(self, bits, at, fields, place):
        '''Data of one slave. Returns it as the docstring has it, and where it ends.'''
        begin, values, words = at, [], []
        for name, short, n in fields:
            if n == 0:
                values.append(0 if name == 'mt' else None)
                continue
            value = number(bits[at:at + n])
            self.ann(self.edges[at], self.edges[at + n], name, '%s %d' % (short, value), str(value))
            values.append(value)
            words.append('%s %d' % (short, value))
            at += n
        end = at + CRC_BITS
        crc, right = number(bits[at:end]), crc6(bits[begin:at])
        verdict = 'ok' if crc == right else 'wrong'
        self.ann(self.edges[at], self.edges[end], 'crc', 'CRC %02X %s' % (crc, verdict), 'CRC %s' % verdict, '%02X' % crc)
        which = 'slave %d: ' % (place + 1) if len(self.slaves) > 1 else ''
        self.ann(self.edges[begin], self.edges[end], 'position', which + ' '.join(words) + ' CRC ' + verdict,
                 'ST %d' % values[1])
        if crc != right:
            self.warn(self.edges[at], self.edges[end], which + 'CRC %02X is wrong, expected %02X' % (crc, right))
        bytes_needed = -(-(end - begin) // 8)
        self.put(self.edges[begin], self.edges[end], self.out_binary,
                 [0, number(bits[begin:end]).to_bytes(bytes_needed, 'big')])
        return tuple(values) + (crc == right,), end
