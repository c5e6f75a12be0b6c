# SPDX-License-Identifier: MIT
"""FMUs as the command writes them, once each, and an importer's low level on them."""

import os
import pathlib
import shutil
import subprocess
from collections.abc import Callable, Iterator
from typing import Any

import fmpy  # type: ignore[import-untyped]
import pytest
from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]

DREHGEBER = os.environ.get("DREHGEBER", "build/release/drehgeber")


class Fmu:
    """One FMU, unpacked."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = str(path)
        self.description = fmpy.read_model_description(self.path)
        self.folder = fmpy.extract(self.path)
        self.names = {v.name: v.valueReference for v in self.description.modelVariables}
        self.kinds = {v.name: v.type for v in self.description.modelVariables}


class Slave:
    """An instance of FMI 3, by names; time goes in steps."""

    def __init__(self, fmu: Fmu, early: bool = False, **settings: Any) -> None:
        self.fmu = fmu
        self.time = 0.0
        self._slave = FMU3Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder,
                                modelIdentifier="drehgeber", instanceName="it")
        self._slave.instantiate(eventModeUsed=True, earlyReturnAllowed=early)
        self._slave.enterInitializationMode()
        for name, value in settings.items():
            self.set(name, value)
        self._slave.exitInitializationMode()
        self._slave.enterStepMode()

    def _kind(self, name: str) -> str:
        return str(self.fmu.kinds[name])

    def set(self, name: str, value: Any) -> None:
        name = name.replace("__", ".")
        getattr(self._slave, "set" + self._kind(name))([self.fmu.names[name]], [value])

    def get(self, name: str) -> Any:
        return getattr(self._slave, "get" + self._kind(name))([self.fmu.names[name]])[0]

    def step(self, span: float) -> bool:
        """@return whether a clock ticks"""
        event, _, _, last = self._slave.doStep(self.time, span)
        self.time = last
        return bool(event)

    def tick(self, clock: str) -> None:
        """An event in which one input clock ticks."""
        self._slave.enterEventMode()
        self._slave.setClock([self.fmu.names[clock]], [True])
        self._slave.updateDiscreteStates()
        self._slave.enterStepMode()

    def send(self, wire: str, data: bytes) -> bytes:
        """An event that brings `data`, and what the encoder says at once."""
        self._slave.enterEventMode()
        self._slave.setClock([self.fmu.names[wire + ".Rx_Clock"]], [True])
        self._slave.setBinary([self.fmu.names[wire + ".Rx_Data"]], [data])
        answer = self._fetch(wire)
        self._slave.updateDiscreteStates()
        self._slave.enterStepMode()
        return answer

    def _fetch(self, wire: str) -> bytes:
        if not self._slave.getClock([self.fmu.names[wire + ".Tx_Clock"]])[0]:
            return b""
        return bytes(self._slave.getBinary([self.fmu.names[wire + ".Tx_Data"]])[0])

    def fetch(self, wire: str) -> bytes:
        """An event in which the encoder's clock ticks, if it does."""
        self._slave.enterEventMode()
        data = self._fetch(wire)
        self._slave.updateDiscreteStates()
        self._slave.enterStepMode()
        return data

    def save(self) -> bytes:
        state = self._slave.getFMUState()
        data = bytes(self._slave.serializeFMUState(state))
        self._slave.freeFMUState(state)
        return data

    def restore(self, data: bytes, time: float) -> None:
        state = self._slave.deserializeFMUState(data)
        self._slave.setFMUState(state)
        self._slave.freeFMUState(state)
        self.time = time

    def close(self) -> None:
        self._slave.terminate()
        self._slave.freeInstance()


class Slave2:
    """An instance of FMI 2.0, by names; time goes in steps."""

    def __init__(self, fmu: Fmu, **settings: Any) -> None:
        self.time = 0.0
        self.fmu = fmu
        self.slave = FMU2Slave(guid=fmu.description.guid, unzipDirectory=fmu.folder,
                               modelIdentifier="drehgeber", instanceName="it")
        self.slave.instantiate()
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        for name, value in settings.items():
            self.set(fmu.kinds[name], name, value)
        self.slave.exitInitializationMode()

    def set(self, kind: str, name: str, value: object) -> None:
        getattr(self.slave, "set" + kind)([self.fmu.names[name]], [value])

    def get(self, kind: str, name: str) -> Any:
        return getattr(self.slave, "get" + kind)([self.fmu.names[name]])[0]

    def step(self, span: float) -> None:
        self.slave.doStep(self.time, span)
        self.time += span

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()


@pytest.fixture(scope="session")
def make(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Fmu]]:
    made: dict[tuple[str, ...], Fmu] = {}

    def one(*words: str) -> Fmu:
        if words not in made:
            path = tmp_path_factory.mktemp("fmu") / "encoder.fmu"
            subprocess.run([DREHGEBER, "fmu", *words, "--output", str(path)], check=True)
            made[words] = Fmu(path)
        return made[words]

    yield one
    for fmu in made.values():
        shutil.rmtree(fmu.folder, ignore_errors=True)
