"""The tools of one map over standard input and output, or over HTTP."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.transport_security import TransportSecuritySettings
from mcp_types import CallToolResult, InputRequiredResult

from app.agents.editing_tools import add_editing_tools
from app.agents.library_tools import LIBRARY_INSTRUCTIONS, add_library_tools
from app.agents.reading_tools import INSTRUCTIONS, add_reading_tools
from app.page.other_poses import chosen_run
from app.served_map.shared_map import SharedMap
from app.server.access_rules import AccessRules
from app.server.guard import Guard
from app.server.run_server import Server, address_of, open_socket
from razer.plugins import Trust

if TYPE_CHECKING:
    from app.served_map.shared_library import SharedLibrary

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


def tools_of(shared: SharedMap | None, *, allow_edits: bool = False, library: SharedLibrary | None = None) -> MCPServer:
    """The tools of a map, of a library of maps, or of both; those that change the map only where that is allowed."""
    said = [INSTRUCTIONS] * (shared is not None) + [LIBRARY_INSTRUCTIONS] * (library is not None)
    server = _ExactServer("razer", instructions=" ".join(said), version=metadata.version("razer"), log_level="WARNING")
    if shared is not None:
        add_reading_tools(server, shared)
        if allow_edits:
            add_editing_tools(server, shared)
    if library is not None:
        add_library_tools(server, library)
    return server


@dataclass(frozen=True)
class Offered:
    """What agents are offered: a run, a library of maps by its URI, or both; and whether they may edit the run."""

    run: Path | None
    library: str | None
    trust: Trust
    allow_edits: bool

    def tools(self) -> MCPServer:
        """The tools of both; raises BadInput where one cannot be used."""
        shared = None if self.run is None else SharedMap(chosen_run(self.run), trust=self.trust)
        library = None
        if self.library is not None:
            from app.served_map.shared_library import SharedLibrary  # late: it needs the extra `library`

            library = SharedLibrary(self.library, self.trust)
        return tools_of(shared, allow_edits=self.allow_edits, library=library)


def serve_stdio(offered: Offered) -> None:
    """Serve over standard input and output until the input ends. Raises BadInput where nothing can be used."""
    anyio.run(offered.tools().run_stdio_async)


def serve_http(offered: Offered, rules: AccessRules, port: int) -> None:
    """Serve over streamable HTTP until a signal comes. Raises BadInput where the map or the place cannot be used."""
    server = offered.tools()
    # The guard has checked both already, and knows more of them.
    unchecked = TransportSecuritySettings(enable_dns_rebinding_protection=False)
    app = Guard(server.streamable_http_app(streamable_http_path=PATH, transport_security=unchecked), rules)
    listener = open_socket(rules.host, port)
    print(
        f"tools of {offered.run or offered.library} at {address_of(listener).rstrip('/')}{PATH} (Ctrl-C ends it)",
        file=sys.stderr,
        flush=True,
    )
    Server(app, lambda: None).run([listener])
