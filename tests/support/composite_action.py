"""A runner of the shell steps of a composite GitHub Action on this machine, without those that use other actions."""

import os
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml


@dataclass
class ActionRun:
    """What the steps of an action left behind.

    exit_code : of the step that failed, else 0
    summary : the text of the job's summary
    log : what the steps printed
    outputs : by step
    """

    exit_code: int = 0
    summary: str = ""
    log: str = ""
    outputs: dict[str, dict[str, str]] = field(default_factory=dict)


def run_action(
    action: Path,
    workspace: Path,
    temporary: Path,
    inputs: dict[str, str],
    environment: dict[str, str],
    given: dict[str, dict[str, str]],
    skip: tuple[str, ...] = (),
) -> ActionRun:
    """Run the steps of `action` in a workspace until one fails.

    environment : what GitHub sets beside the files and folders made here
    given : outputs of steps that are not run, by their ids
    skip : names of steps that are not run
    """
    definition = yaml.safe_load(action.read_text("utf-8"))
    values = {name: entry.get("default", "") for name, entry in definition["inputs"].items()} | inputs
    run = ActionRun(outputs=dict(given))
    summary = temporary / "summary.md"
    for number, step in enumerate(definition["runs"]["steps"]):
        if "run" not in step or step.get("name") in skip or not _is_wanted(step, values):
            continue
        assert step["shell"] == "bash"
        output = temporary / f"output-{number}"
        for file in (summary, output):
            file.touch()
        own = {name: _substitute(str(text), values, run.outputs) for name, text in step.get("env", {}).items()}
        process = subprocess.run(
            ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", "-c", step["run"]],  # noqa: S607
            cwd=workspace,
            env={
                **os.environ,
                **environment,
                **own,
                "GITHUB_ACTION_PATH": str(action.parent),
                "GITHUB_OUTPUT": str(output),
                "GITHUB_STEP_SUMMARY": str(summary),
                "RUNNER_TEMP": str(temporary),
            },
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        run.log += process.stdout + process.stderr
        lines = output.read_text("utf-8").splitlines()
        run.outputs[step.get("id", str(number))] = dict(line.split("=", 1) for line in lines)
        run.exit_code = process.returncode
        if process.returncode:
            break
    run.summary = summary.read_text("utf-8")
    return run


def _is_wanted(step: dict[str, Any], inputs: dict[str, str]) -> bool:
    condition = step.get("if")
    if condition is None:
        return True
    found = re.fullmatch(r"inputs\.([\w-]+) != ''", condition)
    assert found, condition
    return inputs[found[1]] != ""


def _substitute(text: str, inputs: dict[str, str], outputs: dict[str, dict[str, str]]) -> str:
    """Return a text with its expressions replaced: inputs and outputs of steps, empty where a step was not run."""

    def find(expression: re.Match[str]) -> str:
        kind, *names = expression[1].split(".")
        if kind == "inputs":
            return inputs[names[0]]
        assert kind == "steps", expression[0]
        assert names[1] == "outputs"
        return outputs.get(names[0], {}).get(names[2], "")

    return re.sub(r"\$\{\{ ([\w.-]+) \}\}", find, text)
