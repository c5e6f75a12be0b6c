# SPDX-License-Identifier: MIT
"""What an encoder senses, while it follows points that clients name or have in a file."""
import pytest

from rig import PATIENCE_S, Client, start_rig

RIG = """[rig]
control = tcp:127.0.0.1:0
control = tcp:127.0.0.1:0
[encoder one]
model = s3684-biss
wire = sim
"""
ILLEGAL, CONFLICT, FILE_NAME = -224, -221, -256
HOLDS_FOR_S = 10 * PATIENCE_S


@pytest.fixture
def clients(tmp_path):
    (tmp_path / "rig.ini").write_text(RIG)
    rig = start_rig(tmp_path / "rig.ini", "--files", tmp_path)
    both = [Client(address) for address in rig.controls]
    yield both
    for client in both:
        client.close()
    assert rig.clean_up() == []


def test_points_are_followed(clients):
    """A point holds until the next one with STEP; behind the last one nothing is followed any more."""
    client, _ = clients
    assert client.ask("WORL:TEMP:PROF?") == '""'
    client.do(f"WORL:TEMP:PROF:POIN 0,41.5,{HOLDS_FOR_S}S,90,STEP")
    assert client.ask("WORL:TEMP?;TEMP:PROF?;PROF:STAT?") == '41.500;"points,STEP";1'
    client.do(f"WORL:TEMP:PROF:POIN 0,-12.25,{HOLDS_FOR_S}S,-12.25")
    assert client.ask("WORL:TEMP?;TEMP:PROF?;PROF:STAT?") == '-12.250;"points";1'
    client.do("WORL:TEMP:PROF:STAT OFF")
    assert client.ask("WORL:TEMP?;TEMP:PROF?;PROF:STAT?") == '-12.250;"";0'
    client.do("WORL:TEMP:PROF:POIN 0,7")
    assert client.ask("WORL:TEMP?;TEMP:PROF?;PROF:STAT?") == '7.000;"";0'


def test_a_straight_line_lies_between_points(clients):
    client, _ = clients
    client.do(f"WORL:TEMP:PROF:POIN 0,20,{HOLDS_FOR_S}S,120")
    assert 20 <= float(client.ask("WORL:TEMP?")) < 20 + 100 * PATIENCE_S / HOLDS_FOR_S


def test_a_loop_that_takes_no_time_is_refused(clients, tmp_path):
    """What was followed goes on."""
    client, _ = clients
    client.do(f"WORL:TEMP:PROF:POIN 0,41.5,{HOLDS_FOR_S}S,41.5")
    (tmp_path / "x.csv").write_text("0,1\n")
    client.send('WORL:TEMP:PROF "x.csv,LOOP"')
    told = client.ask("SYST:ERR?")
    assert told.startswith(f"{ILLEGAL},") and "a loop needs a time above 0" in told
    assert client.ask("WORL:TEMP?;TEMP:PROF?") == '41.500;"points"'


def test_a_quantity_reads_one_file_at_a_time(clients, tmp_path):
    """The other client is told; the first one's file is followed."""
    first, second = clients
    count = 400_000
    (tmp_path / "long.csv").write_text("".join(f"{i},41.5\n" for i in range(count)))
    (tmp_path / "short.csv").write_text("0,1\n")
    first.send('WORL:TEMP:PROF "long.csv"\nSYST:ERR?')
    second.send('WORL:TEMP:PROF "short.csv"')
    told = second.ask("SYST:ERR?")
    assert told.startswith(f"{CONFLICT},") and "another client's file is being read for it" in told
    assert first.answers.readline().startswith("0,")
    assert first.ask("WORL:TEMP?;TEMP:PROF?") == '41.500;"long.csv"'
    second.do('WORL:TEMP:PROF "short.csv"')
    assert second.ask("WORL:TEMP?") == "1.000"


def test_courses_of_clients_have_so_much_memory(tmp_path):
    """Three points: whatever is beyond is refused and nothing changes; what is replaced or has ended gives room."""
    (tmp_path / "rig.ini").write_text(RIG.replace("[encoder one]", "memory = 48\n[encoder one]"))
    (tmp_path / "long.csv").write_text("0,1\n1,2\n2,3\n3,4\n")
    rig = start_rig(tmp_path / "rig.ini", "--files", tmp_path)
    with Client(rig.controls[0]) as client:
        client.do(f"WORL:TEMP:PROF:POIN 0,41.5,{HOLDS_FOR_S}S,41.5")
        client.send(f"WORL:SUPP:PROF:POIN 0,5V,{HOLDS_FOR_S}S,4V")
        told = client.ask("SYST:ERR?")
        assert told.startswith('-225,"Out of memory;') and "[rig] memory has 48 bytes for courses" in told
        client.send('WORL:TEMP:PROF "long.csv"')
        assert client.ask("*OPC?;:SYST:ERR?").startswith("1;-225,")
        assert client.ask("WORL:TEMP?;TEMP:PROF?;:WORL:SUPP:PROF?") == '41.500;"points";""'
        client.do(f"WORL:TEMP:PROF:POIN 0,40,1S,41,{HOLDS_FOR_S}S,41")
        client.do("WORL:TEMP:PROF:STAT OFF")
        client.do(f"WORL:SUPP:PROF:POIN 0,5V,{HOLDS_FOR_S}S,5V")
    assert rig.clean_up() == []
