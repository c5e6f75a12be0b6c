# SPDX-License-Identifier: MIT
"""labgrid: a rig of virtual encoders as a resource, and the driver that runs it. What a device under test has
on its wires is at encoder.address; what happens to the encoders is the driver's."""
import attr
import drehgeber
from labgrid.driver import Driver
from labgrid.factory import target_factory
from labgrid.resource import Resource
from labgrid.step import step


@target_factory.reg_resource
@attr.s(eq=False)
class EncoderRig(Resource):
    """`path`: a rig file, relative to the environment's."""

    path = attr.ib(validator=attr.validators.instance_of(str))


@target_factory.reg_driver
@attr.s(eq=False)
class EncoderRigDriver(Driver):
    """The rig runs while the driver is active."""

    bindings = {"rig": EncoderRig}

    def on_activate(self):
        self.running = drehgeber.run(self.target.env.config.resolve_path(self.rig.path))

    def on_deactivate(self):
        self.running.close()

    @Driver.check_active
    @step(args=["name"])
    def encoder(self, name):
        """An encoder of the rig: its address, shaft, world and state."""
        return self.running.encoders[name]

    @Driver.check_active
    @step(args=["name", "degrees"])
    def move(self, name, degrees):
        """Turn the shaft that it sits on, and wait until it is there."""
        self.encoder(name).shaft.move(degrees, rpm=600)

    @Driver.check_active
    @step(args=["name", "fault"])
    def fail(self, name, fault, **limits):
        """Let a fault happen; `count`, `probability` or `duration_ms` end it."""
        self.encoder(name).set_fault(fault, **limits)
