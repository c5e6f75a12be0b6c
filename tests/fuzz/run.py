# SPDX-License-Identifier: MIT
"""A fuzz target on its corpus and for a while on new inputs. Fails with the target, and below a floor. No
seconds: on its corpus.

usage: run.py TARGET SECONDS EXECUTIONS_PER_SECOND EDGES

Inputs that crash it are left beside the target. New inputs are not kept here: tools/fuzz does that.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
STATUS = re.compile(r"^#(\d+)\s+([A-Za-z]+)\s+cov: (\d+)", re.M)
EXECUTIONS = re.compile(r"^stat::number_of_executed_units: (\d+)", re.M)
HANG_S = 10
PATIENCE_S = 240
TAIL = 4000


def count(inputs) -> int:
    return sum(path.is_file() for path in inputs.iterdir())


def main():
    target, seconds = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    floor_executions, floor_edges = int(sys.argv[3]) * seconds, int(sys.argv[4])
    corpus, words = HERE / "corpus" / target.name, HERE / f"{target.name}.dict"
    with tempfile.TemporaryDirectory() as new:
        span = f"-max_total_time={seconds}" if seconds else "-runs=0"
        call = [target, span, f"-timeout={HANG_S}", f"-dict={words}",
                "-print_final_stats=1", "-close_fd_mask=1", f"-artifact_prefix={target}-",
                new, corpus]
        ended = subprocess.run(call, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               errors="replace", timeout=seconds + PATIENCE_S)
    status, executed = STATUS.findall(ended.stderr), EXECUTIONS.findall(ended.stderr)
    if ended.returncode != 0 or not status or not executed:
        print(ended.stderr[-TAIL:])
        sys.exit(f"{target.name} ended with {ended.returncode}")
    inputs, executions, edges = count(corpus), int(executed[-1]), int(status[-1][2])
    new_executions = max(0, executions - inputs)
    print(f"{target.name}: {inputs} inputs, {new_executions} new executions (floor "
          f"{floor_executions}), {edges} edges (floor {floor_edges})")
    if new_executions < floor_executions or edges < floor_edges:
        sys.exit(f"{target.name}: below its floor")


main()
