# SPDX-License-Identifier: MIT
"""What only an importer of FMI 2.0 calls, and what every setter answers: 0 is OK, 1 a warning."""

import ctypes
from collections.abc import Callable
from typing import Any

import pytest
from conftest import Fmu, Slave, Slave2
from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]

Make = Callable[..., Fmu]
OK = 0


def test_versions_are_told(make: Make) -> None:
    """Functions that both standards demand of every FMU."""
    fmu = make("f3668", "--fmi", "2")
    two = FMU2Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber",
                    instanceName="it")
    assert (two.getVersion(), two.getTypesPlatform()) == ("2.0", "default")
    fmu = make("f3668")
    three = FMU3Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber",
                      instanceName="it")
    assert three.getVersion() == "3.0"


def test_truth_values_of_fmi_2(make: Make) -> None:
    """A fault comes and goes, and so does the power."""
    slave = Slave2(make("f3668", "--fmi", "2"))
    slave.set("Real", "shaft.angle", 6.283185307179586)
    slave.step(1.0)
    assert slave.get("Boolean", "power") == 1 and slave.get("Boolean", "fault.temperature_high") == 0
    slave.set("Boolean", "fault.temperature_high", True)
    slave.step(1.0)
    assert slave.get("Real", "error.code") == 0x4200
    assert slave.get("Boolean", "fault.temperature_high") == 1 and slave.get("Boolean", "fault.temperature_low") == 0
    slave.set("Boolean", "fault.temperature_high", False)
    slave.step(1.0)
    assert slave.get("Real", "error.code") == 0 and slave.get("Boolean", "fault.temperature_high") == 0
    assert slave.get("Real", "position") == 65536
    slave.set("Boolean", "power", False)
    slave.step(1.0)
    assert slave.get("Boolean", "power") == 0 and slave.get("Real", "position") == 0
    slave.set("Boolean", "power", True)
    slave.step(1.0)
    assert slave.get("Boolean", "power") == 1 and slave.get("Real", "position") == 65536
    with pytest.raises(Exception, match="Boolean"):
        slave.set("Boolean", "shaft.angle", True)
    with pytest.raises(Exception, match="Boolean"):
        slave.slave.getBoolean([0xFFFFFF])
    slave.close()


def test_several_truth_values_of_fmi_2(make: Make) -> None:
    """All of a call, in its order."""
    fmu = make("s3684-biss", "--fmi", "2")
    slave = Slave2(fmu)
    names = ["fault.led_current_high", "power", "fault.watchdog_fired"]
    references = [fmu.names[name] for name in names]
    assert slave.slave.getBoolean(references) == [0, 1, 0]
    slave.slave.setBoolean(references, [True, True, False])
    slave.step(0.2)
    assert slave.slave.getBoolean(references) == [1, 1, 0]
    assert slave.get("Boolean", "nERR") == 0
    slave.close()


def test_integers_of_fmi_2(make: Make) -> None:
    """A parameter makes another encoder; when time goes on it is fixed. A number counts for a Real, too."""
    fmu = make("s3684-rs485", "--fmi", "2")
    slave = Slave2(fmu, periods=1024, steps=512)
    names = ["periods", "steps", "address"]
    assert slave.slave.getInteger([fmu.names[name] for name in names]) == [1024, 512, 0x40]
    slave.set("Real", "shaft.angle", 6.283185307179586)
    slave.step(1.0)
    assert slave.get("Real", "position") == 1024 * 512
    with pytest.raises(Exception, match="Integer"):
        slave.set("Integer", "periods", 2048)
    with pytest.raises(Exception, match="Integer"):
        slave.set("Integer", "power", 0)
    with pytest.raises(Exception, match="Integer"):
        slave.slave.getInteger([0xFFFFFF])
    assert slave.get("Integer", "periods") == 1024 and slave.get("Boolean", "power") == 1
    slave.set("Integer", "world.supply_mv", 4800)
    assert slave.get("Real", "world.supply_mv") == 4800
    slave.close()


def test_an_integer_out_of_range_is_an_error_of_fmi_2(make: Make) -> None:
    with pytest.raises(Exception, match="Integer"):
        Slave2(make("f3668", "--fmi", "2"), node=128)


# --- statuses, as the shared object answers them: fmpy takes a warning for good

CALLS: dict[str, list[tuple[str, str, Any]]] = {
    "2": [("Real", "shaft.angle", ctypes.c_double(1)), ("Integer", "node", ctypes.c_int32(9)),
          ("Boolean", "fault.temperature_high", ctypes.c_int(1)), ("String", "mt_bits", ctypes.c_char_p(b"16"))],
    "3": [("Float64", "shaft.angle", ctypes.c_double(1)), ("Int64", "node", ctypes.c_int64(9)),
          ("Boolean", "fault.temperature_high", ctypes.c_bool(True)), ("String", "mt_bits", ctypes.c_char_p(b"16"))],
}


@pytest.mark.parametrize("version", ["3", "2"])
def test_setters_and_getters_answer_ok(make: Make, version: str) -> None:
    fmu = make("f3668", "--fmi", version)
    kind = FMU3Slave if version == "3" else FMU2Slave
    slave = kind(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber", instanceName="it")
    slave.instantiate()
    if version == "2":
        slave.setupExperiment()
    slave.enterInitializationMode()
    component = ctypes.c_void_p(slave.component)
    length = [ctypes.c_size_t(1)] * (1 if version == "3" else 0)
    for verb in ("Set", "Get"):
        for name, variable, value in CALLS[version]:
            reference, room = ctypes.c_uint32(fmu.names[variable]), type(value)(value.value)
            call = getattr(slave.dll, f"fmi{version}{verb}{name}")
            call.argtypes, call.restype = None, ctypes.c_int
            arguments = [component, ctypes.byref(reference), ctypes.c_size_t(1), ctypes.byref(room), *length]
            assert call(*arguments) == OK, (verb, name)
            assert room.value == value.value, (verb, name)
    slave.exitInitializationMode()
    slave.terminate()
    slave.freeInstance()


def test_values_and_variables_that_do_not_count_the_same_are_errors(make: Make) -> None:
    """FMI 3.0: room for fewer values than there are variables."""
    fmu = make("f3668")
    slave = FMU3Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber",
                      instanceName="it")
    slave.instantiate()
    slave.enterInitializationMode()
    component = ctypes.c_void_p(slave.component)
    for verb in ("Set", "Get"):
        for name, variable, value in CALLS["3"]:
            references = (ctypes.c_uint32 * 2)(*[fmu.names[variable]] * 2)
            call = getattr(slave.dll, f"fmi3{verb}{name}")
            call.argtypes, call.restype = None, ctypes.c_int
            room = (type(value) * 2)(value.value, value.value)
            assert call(component, references, ctypes.c_size_t(2), room, ctypes.c_size_t(2)) == OK, (verb, name)
            assert call(component, references, ctypes.c_size_t(2), room, ctypes.c_size_t(1)) == 3, (verb, name)
    slave.freeInstance()


# --- what an encoder has not

# Functions that FMI 3.0 demands of every FMU, and what they take behind the instance: a size, a reference, a truth value,
# a moment, a pointer.
SIZES = {"n": ctypes.c_size_t(1), "r": ctypes.c_uint32(1), "b": ctypes.c_bool(False), "d": ctypes.c_double(0), "p": None}
NOT_HERE = {
    "GetNumberOfVariableDependencies": "rp", "GetVariableDependencies": "rppppn",
    "GetDirectionalDerivative": "pnpnpnpn", "GetAdjointDerivative": "pnpnpnpn",
    "GetIntervalDecimal": "pnpp", "GetIntervalFraction": "pnppp", "GetShiftDecimal": "pnp", "GetShiftFraction": "pnpp",
    "SetIntervalDecimal": "pnp", "SetIntervalFraction": "pnpp", "SetShiftDecimal": "pnp", "SetShiftFraction": "pnpp",
    "EnterContinuousTimeMode": "", "CompletedIntegratorStep": "bpp", "SetTime": "d", "SetContinuousStates": "pn",
    "GetContinuousStateDerivatives": "pn", "GetEventIndicators": "pn", "GetContinuousStates": "pn",
    "GetNominalsOfContinuousStates": "pn", "GetNumberOfEventIndicators": "p", "GetNumberOfContinuousStates": "p",
    "GetOutputDerivatives": "pnppn", "ActivateModelPartition": "rd",
}
TYPES = ["Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "UInt64"]
IDLE = {"SetDebugLogging": "bnp", "EnterConfigurationMode": "", "ExitConfigurationMode": "", "EvaluateDiscreteStates": ""}
ERROR = 3


def test_what_is_not_here_is_an_error_of_fmi_3(make: Make) -> None:
    """Nothing to differentiate, no clock with an interval, no variable of these types; what has nothing to do is OK."""
    fmu = make("f3668")
    slave = FMU3Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber",
                      instanceName="it")
    slave.instantiate()
    component = ctypes.c_void_p(slave.component)

    def call(name: str, of: ctypes.c_void_p | None, *arguments: object) -> int:
        function = getattr(slave.dll, "fmi3" + name)
        function.argtypes, function.restype = None, ctypes.c_int
        return int(function(of, *arguments))

    for name, letters in NOT_HERE.items():
        assert call(name, component, *[SIZES[letter] for letter in letters]) == ERROR, name
    for verb in ("Get", "Set"):
        for name in TYPES:
            for count, result in (0, OK), (1, ERROR):
                n = ctypes.c_size_t(count)
                assert call(verb + name, component, None, n, None, n) == result, (verb, name)
    for name, letters in IDLE.items():
        arguments = [SIZES[letter] for letter in letters]
        assert call(name, component, *arguments) == OK, name
        assert call(name, None, *arguments) == ERROR, name
    slave.freeInstance()


def test_only_co_simulation_of_this_very_fmu(make: Make) -> None:
    """FMI 3.0, 2.3.1: what is no instance is NULL."""
    fmu = make("f3668")
    dll = FMU3Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber",
                    instanceName="it").dll
    token = fmu.description.guid.encode()

    def made(kind: str, given: bytes, *more: object) -> int | None:
        function = getattr(dll, "fmi3Instantiate" + kind)
        function.argtypes, function.restype = None, ctypes.c_void_p
        off = ctypes.c_bool(False)
        result: int | None = function(b"it", given, None, off, off, *more)
        return result

    assert made("ModelExchange", token, None, None) is None
    assert made("ScheduledExecution", token, None, None, None, None, None) is None
    events = [ctypes.c_bool(False), ctypes.c_bool(False), None, ctypes.c_size_t(0), None, None, None]
    assert made("CoSimulation", token + b"x", *events) is None
    instance = made("CoSimulation", token, *events)
    assert instance is not None
    dll.fmi3FreeInstance(ctypes.c_void_p(instance))


# --- events of FMI 3.0

def test_event_is_told_when_a_clock_ticks_only(make: Make) -> None:
    """An importer enters event mode for it: told at every step, it costs every step."""
    slave = Slave(make("f3668"))
    assert slave.step(0.5)
    assert slave.fetch("CanChannel") != b""
    assert not slave.step(1e-3)
    assert slave.fetch("CanChannel") == b""
    slave.close()
