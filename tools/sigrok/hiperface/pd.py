# SPDX-License-Identifier: MIT
'''
OUTPUT_PYTHON: [TYPE, (ADDRESS, COMMAND, DATA, WELL)]
 - 'REQUEST', 'REPLY': well when length, check sum and every character are right.
 - 'ERROR': a reply that is an error response; DATA is the code.
 - 'NO REPLY': the request that has none.
'''
import re
from functools import reduce
from operator import xor

import sigrokdecode as srd

from .lists import COMMANDS, ERRORS

RX = 0
FRAME_LEAST = 3
BROADCAST = 0xFF
WARNING_BIT = 0x80
READ_DATA = 0x4A
READ_STATUS = 0x50
RESET = 0x53
ASSIGN_ADDRESS = 0x55
# Of what is no command.
REACTION_MS = 5
# Who talks.
REQUEST, REPLY = 0, 1

ANNOTATIONS = (
    ('address', 'Address'),
    ('command', 'Command'),
    ('data', 'Data'),
    ('checksum', 'Check sum'),
    ('request', 'Request'),
    ('reply', 'Reply'),
    ('error', 'Error response'),
    ('warning', 'Warning'),
)
CLASS = {name: number for number, (name, _) in enumerate(ANNOTATIONS)}


def ascii_of(data):
    '''Up to the zero.'''
    return ''.join(chr(byte) if 0x20 <= byte <= 0x7E else '?' for byte in data.split(b'\0')[0])


def plain_hex(data):
    return ''.join(' %02X' % byte for byte in data)


SIGNS = {
    '#': lambda data: plain_hex(data).replace(' ', '') + 'h',
    '@': lambda data: str(int.from_bytes(data, 'big')),
    '%': lambda data: str(int.from_bytes(data, 'big', signed=True)),
    '$': ascii_of,
    '&': plain_hex,
}


def fill_in(words, data):
    '''The words with their data in place of the signs.'''
    def figure(match):
        nonlocal data
        n = len(data) if match[1] == '&' else int(match[2])
        field, data = data[:n], data[n:]
        return SIGNS[match[1]](field) if len(field) == n else '?'
    text = re.sub(r'([#@%$&])(\d*)', figure, words)
    return text + (', too many:' + plain_hex(data) if data else '')


def status_of(code):
    text = ERRORS.get(code, 'unknown')
    return 'error %02Xh %s' % (code, text) if code else text


class Frame:
    '''Characters without a timeout between them: [(ss, es, byte)], and what UART found wrong.'''

    def __init__(self, line):
        self.line = line
        self.side = None       # known when it is over
        self.characters = []
        self.damage = []

    def add(self, ss, es, byte, damage):
        self.characters.append((ss, es, byte))
        self.damage += damage

    ss = property(lambda self: self.characters[0][0])
    es = property(lambda self: self.characters[-1][1])
    bytes = property(lambda self: bytes(byte for _, _, byte in self.characters))
    whole = property(lambda self: len(self.characters) >= FRAME_LEAST)
    address = property(lambda self: self.characters[0][2])
    command = property(lambda self: self.characters[1][2])
    data = property(lambda self: self.bytes[2:-1])
    right = property(lambda self: self.whole and reduce(xor, self.bytes) == 0)


class Decoder(srd.Decoder):
    api_version = 3
    id = 'hiperface'
    name = 'HIPERFACE'
    longname = 'HIPERFACE-compatible parameter channel'
    desc = 'Motor feedback encoders: requests and replies over RS485.'
    license = 'mit'
    inputs = ['uart']
    outputs = ['hiperface']
    tags = ['Embedded/industrial', 'Sensor']
    options = (
        {'id': 'line', 'desc': 'RX has', 'default': 'requests', 'values': ('requests', 'both')},
        {'id': 'timeout_bits', 'desc': 'Silence that ends a frame (bit times)', 'default': 44, 'values': (44, 11)},
    )
    annotations = ANNOTATIONS
    annotation_rows = (
        ('fields', 'Fields', tuple(range(CLASS['address'], CLASS['checksum'] + 1))),
        ('frames', 'Frames', (CLASS['request'], CLASS['reply'], CLASS['error'])),
        ('warnings', 'Warnings', (CLASS['warning'],)),
    )
    binary = (
        ('requests', 'Requests'),
        ('replies', 'Replies'),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None
        self.frame = None      # what is being collected
        self.asked = None      # the request that waits for its reply
        self.damage = []       # of the character that is coming in
        self.glitch = False    # what is coming in is no character
        self.bit = None        # samples

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.out_python = self.register(srd.OUTPUT_PYTHON)
        self.out_binary = self.register(srd.OUTPUT_BINARY)

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def ann(self, ss, es, name, *texts):
        self.put(ss, es, self.out_ann, [CLASS[name], list(texts)])

    def warn(self, frame, text):
        self.ann(frame.ss, frame.es, 'warning', text)

    # --- characters ---

    def decode(self, ss, es, data):
        kind, line, value = data
        if kind == 'DATA':
            bits = value[1]
            self.bit = (bits[-1][2] - bits[0][1]) / len(bits)
        elif kind == 'PARITY ERROR':
            self.damage.append('wrong parity')
        elif kind == 'INVALID STOPBIT':
            self.damage.append('wrong stop bit')
        elif kind in ('STARTBIT', 'INVALID STARTBIT'):
            # UART makes a character of a start bit that is none, too.
            self.glitch = kind != 'STARTBIT'
        elif kind == 'FRAME' and not self.glitch:
            self.character(ss, es, line, value[0])
        elif kind == 'IDLE' and self.frame is not None and line == self.frame.line and self.silent(es):
            self.end_frame()

    def silent(self, at):
        '''Whether a timeout has passed since the frame; half a bit for the clock of whoever sends.'''
        return at - self.frame.es >= (self.options['timeout_bits'] - 0.5) * self.bit

    def character(self, ss, es, line, byte):
        if self.frame is not None and (line != self.frame.line or self.silent(ss)):
            self.end_frame()
        if self.frame is None:
            self.frame = Frame(line)
        damage, self.damage = self.damage, []
        place = len(self.frame.characters) + 1
        self.frame.add(ss, es, byte, ['%s in character %d' % (what, place) for what in damage])
        if self.frame.right and self.is_reply(self.frame):
            # The next request may follow at once, or nothing at all.
            self.end_frame()

    # --- frames ---

    def is_reply(self, frame):
        '''Whether it is a whole reply by its length; on one line for both, to the last request.'''
        command = frame.command & ~WARNING_BIT
        if self.options['line'] == 'both':
            if self.asked is None or command not in (self.asked.command, READ_STATUS):
                return False
        elif frame.line == RX:
            return False
        least, most = COMMANDS[command][1] if command in COMMANDS else (0, 0)
        if command == READ_DATA and len(frame.data) > 2:
            least = most = 3 + frame.data[2]
        return least <= len(frame.data) <= most

    def side_of(self, frame):
        if self.options['line'] == 'both':
            return REPLY if frame.whole and self.is_reply(frame) else REQUEST
        return REQUEST if frame.line == RX else REPLY

    def end_frame(self):
        frame, self.frame = self.frame, None
        frame.side = self.side_of(frame)
        if frame.side == REQUEST:
            self.end_wait(frame)
        if frame.whole:
            self.fields(frame)
        kind, text, wrong = self.words(frame)
        wrong += [] if frame.right or not frame.whole else ['check sum wrong']
        wrong += frame.damage
        self.ann(frame.ss, frame.es, kind, ', '.join([text] + wrong))
        for what in wrong:
            self.warn(frame, '%s: %s' % ('request' if frame.side == REQUEST else 'reply', what))
        if frame.whole:
            command = frame.command if frame.side == REQUEST else frame.command & ~WARNING_BIT
            self.put(frame.ss, frame.es, self.out_python, [kind.upper(), (frame.address, command, frame.data, not wrong)])
        self.put(frame.ss, frame.es, self.out_binary, [frame.side, frame.bytes])
        if frame.side == REPLY:
            self.look_at_reply(frame)
            self.asked = None
        elif frame.whole:
            self.asked = frame

    def end_wait(self, frame):
        '''A request, and the one before was not answered: 53h never is.'''
        asked, self.asked = self.asked, None
        if asked is None or not asked.right or asked.command == RESET:
            return
        self.ann(asked.es, frame.ss, 'warning', 'no reply to %s' % self.command_words(asked))
        self.put(asked.es, frame.ss, self.out_python, ['NO REPLY', (asked.address, asked.command, asked.data, True)])

    def command_words(self, frame):
        return '%02Xh %s' % (frame.command, fill_in(COMMANDS[frame.command][3], frame.data)
                             if frame.command in COMMANDS else 'unknown command')

    def fields(self, frame):
        (first, *_), (second, *_), *_ = frame.characters
        ends = [es for _, es, _ in frame.characters]
        who = 'all' if frame.address == BROADCAST else '%02Xh' % frame.address
        self.ann(first, ends[0], 'address', 'Address ' + who, who)
        self.ann(second, ends[1], 'command', 'Command %02Xh' % frame.command, '%02X' % frame.command)
        if frame.data:
            self.ann(frame.characters[2][0], ends[-2], 'data', 'Data' + plain_hex(frame.data), plain_hex(frame.data)[1:])
        sum_, verdict = frame.bytes[-1], 'ok' if frame.right else 'wrong'
        self.ann(frame.characters[-1][0], ends[-1], 'checksum', 'Check sum %02X %s' % (sum_, verdict), '%02X' % sum_)

    def words(self, frame):
        '''Annotation class, words, and what is wrong with the length.'''
        kind = 'request' if frame.side == REQUEST else 'reply'
        arrow = '-> ' if frame.side == REPLY else ''
        if not frame.whole:
            return kind, arrow + 'too short:' + plain_hex(frame.bytes), ['a frame has %d characters or more' % FRAME_LEAST]
        who = ('all ' if frame.address == BROADCAST else '%02Xh ' % frame.address) + arrow
        if frame.side == REQUEST:
            return kind, who + self.command_words(frame), self.length_problem(frame, frame.command, 0)
        command = frame.command & ~WARNING_BIT
        warning = ', warning' if frame.command & WARNING_BIT else ''
        if command == READ_STATUS and len(frame.data) == 1:
            asked_for = self.asked is not None and self.asked.command == READ_STATUS
            return 'reply' if asked_for else 'error', '%s50h %s%s' % (who, status_of(frame.data[0]), warning), []
        known = command in COMMANDS
        text = fill_in(COMMANDS[command][4], frame.data) if known else 'unknown command'
        return kind, '%s%02Xh %s%s' % (who, command, text, warning), self.length_problem(frame, command, 1)

    def length_problem(self, frame, command, place):
        if command not in COMMANDS:
            return ['no such command']
        least, most = COMMANDS[command][place]
        n = len(frame.data)
        if least <= n <= most:
            return []
        return ['%d data bytes, right are %s' % (n, least if least == most else '%d to %d' % (least, most))]

    def look_at_reply(self, frame):
        '''Whose it is, and when.'''
        asked = self.asked
        if asked is None:
            self.warn(frame, 'reply without a request')
            return
        if not frame.whole or not self.samplerate:
            return
        command = frame.command & ~WARNING_BIT
        if command not in (asked.command, READ_STATUS):
            self.warn(frame, 'reply to another command: %02Xh was asked' % asked.command)
        if frame.address != asked.address and asked.address != BROADCAST and asked.command != ASSIGN_ADDRESS:
            self.warn(frame, '%02Xh answers for %02Xh' % (frame.address, asked.address))
        row = COMMANDS.get(asked.command)
        limit = row[2] if row and row[2] else REACTION_MS
        waited = frame.ss - asked.es - self.options['timeout_bits'] * self.bit
        ms = waited * 1000 / self.samplerate
        if ms > limit + 1000 * self.bit / self.samplerate:
            self.warn(frame, 'reply %.1f ms behind the timeout, at most %d ms' % (ms, limit))
