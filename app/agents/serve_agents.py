"""The tools of one map over standard input and output, or over HTTP."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import anyio
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.transport_security import TransportSecuritySettings
from mcp_types import CallToolResult, InputRequiredResult

from app.agents.editing_tools import add_editing_tools
from app.agents.reading_tools import INSTRUCTIONS, add_reading_tools
from app.page.other_poses import chosen_run
from app.served_map.shared_map import SharedMap
from app.server.access_rules import AccessRules
from app.server.guard import Guard
from app.server.run_server import Server, address_of, open_socket
from razer.plugins import Trust

PATH = "/mcp"


class _ExactServer(MCPServer):
    """Refuses arguments that a tool does not have: a filter that is misspelt would be none."""

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        known = {tool.name: tool.input_schema.get("properties", {}) for tool in await self.list_tools()}
        unknown = sorted(set(arguments) - set(known.get(name, arguments)))
        if unknown:
            raise ToolError(f"{name} has no argument {', '.join(unknown)}; it has {', '.join(known[name])}")
        return await super().call_tool(name, arguments, context)


def tools_of(shared: SharedMap, *, allow_edits: bool) -> MCPServer:
    """The tools of a map; those that change it only where that is allowed."""
    server = _ExactServer("razer", instructions=INSTRUCTIONS, version=metadata.version("razer"), log_level="WARNING")
    add_reading_tools(server, shared)
    if allow_edits:
        add_editing_tools(server, shared)
    return server


def serve_stdio(run: Path, trust: Trust, *, allow_edits: bool) -> None:
    """Serve over standard input and output until the input ends. Raises BadInput where the map cannot be used."""
    server = tools_of(SharedMap(chosen_run(run), trust=trust), allow_edits=allow_edits)
    anyio.run(server.run_stdio_async)


def serve_http(run: Path, trust: Trust, rules: AccessRules, port: int, *, allow_edits: bool) -> None:
    """Serve over streamable HTTP until a signal comes. Raises BadInput where the map or the place cannot be used."""
    server = tools_of(SharedMap(chosen_run(run), trust=trust), allow_edits=allow_edits)
    # The guard has checked both already, and knows more of them.
    unchecked = TransportSecuritySettings(enable_dns_rebinding_protection=False)
    app = Guard(server.streamable_http_app(streamable_http_path=PATH, transport_security=unchecked), rules)
    listener = open_socket(rules.host, port)
    print(f"tools of {run} at {address_of(listener).rstrip('/')}{PATH} (Ctrl-C ends it)", file=sys.stderr, flush=True)
    Server(app, lambda: None).run([listener])
