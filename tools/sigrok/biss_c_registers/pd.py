# SPDX-License-Identifier: MIT
'''
OUTPUT_PYTHON: [TYPE, DATA]
 - 'READ', 'WRITE': (ID, address, value, good) of each register; not good: refused, or a wrong CRC.
 - 'COMMAND': (IDs, none of them for all; command; executed)

CDM(k) goes out in the timeout of frame k, CDS(k) behind its start bit:

  k     0  1    2..4  5..11  12..15  16  17  18  19..26      27..30  31  32
  CDM   S  CTS  ID    ADR    CRC     R   W   S   D (write)   CRC     P   S: a further register
  CDS      IDL0..8                       R   W   19: S, 20..27: D, 28..31: CRC, 32: P
'''
import sigrokdecode as srd

ZEROS = 14
CRC_BITS = 4
CRC_POLYNOMIAL = 0x13
SLAVES_MAX = 8

# Registers that each BiSS-C slave has in the same place: first, last, what they are.
REGISTERS = (
    (0x40, 0x40, 'bank select'),
    (0x41, 0x41, 'EDS bank'),
    (0x42, 0x43, 'profile id'),
    (0x44, 0x47, 'serial number'),
    (0x78, 0x7D, 'device id'),
    (0x7E, 0x7F, 'manufacturer id'),
)
# By the two bits CMD: to all slaves, and to those that are addressed.
BROADCASTS = ('data channels off', 'register and command communication on', 'couplers to bypass', 'reserved')
COMMANDS = ('data channel on', 'register communication of this slave off', 'not described', 'free')

ANNOTATIONS = (
    ('cdm-field', 'CDM field'),
    ('cds-field', 'CDS field'),
    ('register', 'Register'),
    ('access', 'Access'),
    ('command', 'Command'),
    ('warning', 'Warning'),
)
CLASS = {name: number for number, (name, _) in enumerate(ANNOTATIONS)}


def crc4(value, n):
    '''Of the last `n` bits; inverted, as it is sent.'''
    value <<= CRC_BITS
    for shift in range(n - 1, -1, -1):
        if value >> shift + CRC_BITS & 1:
            value ^= CRC_POLYNOMIAL << shift
    return value ^ (1 << CRC_BITS) - 1


def content(address):
    '''What is at an address, in brackets; nothing where that is the slave's own affair.'''
    return ''.join(' (%s)' % what for first, last, what in REGISTERS if first <= address <= last)


class Frame:
    '''One bit in each direction.'''

    def __init__(self, ss, es, cdm, cds):
        self.ss, self.es, self.cdm, self.cds = ss, es, cdm, cds


def cdm_of(frames):
    value = 0
    for frame in frames:
        value = value << 1 | frame.cdm
    return value


def cds_of(frames):
    value = 0
    for frame in frames:
        value = value << 1 | frame.cds
    return value


def take(n):
    '''The next n frames.'''
    frames = []
    for _ in range(n):
        frames.append((yield))
    return frames


class Decoder(srd.Decoder):
    api_version = 3
    id = 'biss_c_registers'
    name = 'BiSS-C registers'
    longname = 'BiSS-C register accesses and commands'
    desc = 'Registers and commands of BiSS-C slaves.'
    license = 'mit'
    inputs = ['biss_c']
    outputs = ['biss_c_registers']
    tags = ['Embedded/industrial', 'Sensor']
    annotations = ANNOTATIONS
    annotation_rows = (
        ('cdm-fields', 'CDM', (CLASS['cdm-field'],)),
        ('cds-fields', 'CDS', (CLASS['cds-field'],)),
        ('registers', 'Registers', (CLASS['register'],)),
        ('accesses', 'Accesses', (CLASS['access'], CLASS['command'])),
        ('warnings', 'Warnings', (CLASS['warning'],)),
    )
    binary = (
        ('read', 'Registers that were read'),
        ('written', 'Registers that were written'),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.zeros = 0          # frames with CDM = 0 without a break
        self.running = None     # the control frame, as a coroutine that takes frames
        self.lost = True        # a CDM = 1 that begins nothing was told about, or is part of what failed

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.out_python = self.register(srd.OUTPUT_PYTHON)
        self.out_binary = self.register(srd.OUTPUT_BINARY)

    def ann(self, ss, es, name, *texts):
        self.put(ss, es, self.out_ann, [CLASS[name], list(texts)])

    def cdm_field(self, frames, *texts):
        self.ann(frames[0].ss, frames[-1].es, 'cdm-field', *texts)

    def cds_field(self, frames, *texts):
        self.ann(frames[0].ss, frames[-1].es, 'cds-field', *texts)

    def warn(self, frames, text):
        self.ann(frames[0].ss, frames[-1].es, 'warning', text)

    # --- from frame to frame ---

    def decode(self, ss, es, data):
        kind, bits = data
        if kind == 'CONTROL':
            cdm, cds = bits
            self.take(Frame(ss, es, cdm, cds or 0), cds is None)

    def take(self, frame, unanswered):
        if self.running is not None:
            self.now = frame
            if unanswered and self.answering:
                self.warn([frame], 'frame without CDS inside a register access')
            try:
                self.running.send(frame)
            except StopIteration:
                self.running = None
        elif frame.cdm and self.zeros >= ZEROS:
            self.what = 'control frame'
            self.first = self.now = frame
            self.lost = self.answering = False
            self.running = self.control(frame)
            next(self.running)
        elif frame.cdm and not self.lost:
            self.warn([frame], 'CDM = 1 behind %d frames with CDM = 0 only: %d are needed' % (self.zeros, ZEROS))
            self.lost = True
        self.zeros = 0 if frame.cdm else self.zeros + 1
        if self.zeros == ZEROS:
            if self.running is not None:
                self.end('aborted')
                self.running = None
            self.lost = False

    def end(self, failure):
        '''The control frame ends before its time; what follows of it is passed over.'''
        frames = [self.first, self.now]
        self.ann(frames[0].ss, frames[-1].es, 'access', '%s: %s' % (self.what, failure))
        self.warn(frames, '%s: %s' % (self.what, failure))
        self.lost = True

    # --- control frames ---

    def control(self, first):
        '''From S on, which is the first frame.'''
        self.cdm_field([first], 'S')
        frames = yield from take(15)
        cts, crc = frames[0].cdm, cdm_of(frames[11:])
        right = crc4(cdm_of(frames[:11]), 11)
        self.cdm_field(frames[:1], 'CTS %d' % cts, str(cts))
        locks = [frame.cds for frame in frames[:SLAVES_MAX]]
        count = (locks + [0]).index(0)
        self.cds_field(frames[:9], 'IDL: slaves with an ID: %d' % count, 'IDL %d' % count)
        if cts:
            slave, address = cdm_of(frames[1:4]), cdm_of(frames[4:11])
            self.cdm_field(frames[1:4], 'ID %d' % slave, str(slave))
            self.cdm_field(frames[4:11], 'ADR %02Xh' % address, '%02X' % address)
            self.what = 'ID %d, register %02Xh' % (slave, address)
        else:
            slaves = [place for place in range(SLAVES_MAX) if frames[1 + place].cdm]
            command = cdm_of(frames[9:11])
            self.cdm_field(frames[1:9], 'IDS %s' % (' '.join(map(str, slaves)) or 'all'))
            self.cdm_field(frames[9:11], 'CMD {:02b}'.format(command))
            self.what = 'command {:02b}'.format(command)
        self.crc_field(self.cdm_field, frames[11:], crc, right)
        if crc != right:
            self.end('CRC4 of the address %X is wrong, expected %X' % (crc, right))
        elif cts:
            yield from self.registers(slave, address, count)
        else:
            yield from self.command(slaves, command)

    def crc_field(self, field, frames, crc, right):
        field(frames, 'CRC %X %s' % (crc, 'ok' if crc == right else 'wrong'), '%X' % crc)

    def registers(self, slave, address, count):
        '''From R on. Commands to all may come in frames that are too short for an answer.'''
        self.answering = True
        r, w, s = yield from take(3)
        for frame, name in ((r, 'R'), (w, 'W'), (s, 'S')):
            self.cdm_field([frame], '%s %d' % (name, frame.cdm), name if frame.cdm else '-')
        # What the slave has got is in the next frame's CDS.
        self.cds_field([w], 'R %d' % w.cds, str(w.cds))
        self.cds_field([s], 'W %d' % s.cds, str(s.cds))
        write = bool(w.cdm)
        self.what = 'ID %d %s %02Xh%s' % (slave, 'write' if write else 'read', address, content(address))
        failure = self.failure_of(r, w, s, slave < count)
        if failure:
            self.end(failure)
            return
        self.what = 'ID %d %s %02Xh' % (slave, 'write' if write else 'read', address)
        values, first, refused = [], self.first, False
        while not refused:
            busy = yield from self.busy()
            if busy is None:
                self.end('no S from the slave, given up')
                return
            frames = [busy] + (yield from take(13))
            value, refused = self.register_of(slave, address + len(values), first, frames, write)
            values.append(value)
            self.what += '%s %02X' % ('' if len(values) > 1 else ':', value)
            if not frames[13].cdm:
                break
            first = frames[13]
        self.ann(self.first.ss, frames[13].es, 'access', self.what)
        self.lost = refused

    def failure_of(self, r, w, s, known):
        '''Why there is no data. The echo of a write that is refused is that of nobody: 00.'''
        echo = (w.cds, s.cds)
        if r.cdm == w.cdm:
            return 'R = W = %d' % r.cdm
        if echo == (r.cdm, r.cdm) and (known or r.cdm):
            return 'refused'
        if echo == (0, 0):
            return 'no answer'
        if echo != (r.cdm, w.cdm):
            return 'wrong echo: R %d, W %d' % echo
        return None if s.cdm else 'given up: no S'

    def busy(self):
        '''The frame with S from the slave. Until then the master repeats its own.'''
        waiting = []
        while True:
            frame = yield
            if frame.cds:
                break
            waiting.append(frame)
            if not frame.cdm:
                return None
        if waiting:
            self.cdm_field(waiting, 'S, repeated', 'S')
            self.cds_field(waiting, 'busy: %d frames' % len(waiting), 'busy')
        return frame

    def register_of(self, slave, address, first, frames, write):
        '''One register, from S of the slave to P of the slave. Returns its value, and whether it was refused.'''
        sent, stop = cdm_of(frames[0:8]), frames[12].cdm
        got, refused = cds_of(frames[1:9]), frames[13].cds
        got_crc, got_right = cds_of(frames[9:13]), crc4(got, 8)
        sent_crc, sent_right = cdm_of(frames[8:12]), crc4(sent, 8)
        problems = []
        if write:
            self.cdm_field(frames[0:8], 'D %02Xh' % sent, '%02X' % sent)
            self.crc_field(self.cdm_field, frames[8:12], sent_crc, sent_right)
            self.cdm_field(frames[12:13], 'P %d' % stop, str(stop))
            if sent_crc != sent_right:
                problems.append('CRC4 of the data %X is wrong, expected %X' % (sent_crc, sent_right))
            if stop:
                problems.append('the stop bit of the master is missing: P = 1')
            if (got, got_crc) != (sent, sent_crc):
                problems.append('echo %02X %X of what was sent as %02X %X' % (got, got_crc, sent, sent_crc))
        elif got_crc != got_right:
            problems.append('CRC4 of the data %X is wrong, expected %X' % (got_crc, got_right))
        if refused:
            problems.append('refused: P = 1')
        self.cds_field(frames[0:1], 'S')
        self.cds_field(frames[1:9], 'D %02Xh' % got, '%02X' % got)
        self.crc_field(self.cds_field, frames[9:13], got_crc, got_right)
        self.cds_field(frames[13:], 'P %d' % refused, str(refused))
        self.cdm_field(frames[13:], 'S: next register' if frames[13].cdm else 'end', 'S' if frames[13].cdm else '-')
        value, name = (sent, 'write') if write else (got, 'read')
        ss, es = first.ss, frames[13].es
        title = '%s %02Xh%s = %02Xh' % (name, address, content(address), value)
        self.ann(ss, es, 'register', ', '.join([title] + problems), '%02X = %02X' % (address, value))
        for problem in problems:
            self.warn(frames, 'ID %d %s %02Xh: %s' % (slave, name, address, problem))
        self.put(ss, es, self.out_python, [name.upper(), (slave, address, value, not problems)])
        self.put(ss, es, self.out_binary, [int(write), bytes([value])])
        return value, bool(refused)

    def command(self, slaves, command):
        '''From S on; EX is at once for all, and behind IDA of those that are addressed.'''
        (s,) = yield from take(1)
        self.cdm_field([s], 'S %d' % s.cdm, 'S' if s.cdm else '-')
        words = (COMMANDS if slaves else BROADCASTS)[command]
        who = 'ID ' + ', '.join(map(str, slaves)) if slaves else 'all'
        self.what = '%s: command %s, %s' % (who, '{:02b}'.format(command), words)
        if not s.cdm:
            self.end('given up: no S')
            return
        frames = yield from take(SLAVES_MAX if slaves else 1)
        taken = [place for place, frame in enumerate(frames) if slaves and frame.cds]
        if slaves:
            self.cds_field(frames, 'IDA %s' % (' '.join(map(str, taken)) or '-'))
        executed = frames[-1].cdm
        self.cdm_field(frames[-1:], 'EX %d' % executed, str(executed))
        silent = [str(slave) for slave in slaves if slave not in taken]
        if not executed:
            self.end('not executed: EX = 0')
        else:
            self.ann(self.first.ss, frames[-1].es, 'command', self.what)
        if silent:
            self.warn([self.first, frames[-1]], '%s: not acknowledged by ID %s' % (self.what, ', '.join(silent)))
        self.put(self.first.ss, frames[-1].es, self.out_python, ['COMMAND', (slaves, command, bool(executed))])
