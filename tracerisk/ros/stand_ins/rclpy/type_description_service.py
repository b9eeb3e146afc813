"""The service that describes the interfaces of a node: it is listed, and refuses to answer."""

from __future__ import annotations

from typing import Any

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"


class TypeDescriptionService:
    """Serves `get_type_description` below the node's name, unless its parameter forbids it."""

    def __init__(self, node: Any) -> None:
        self.enabled = bool(node.get_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM).value)
        if self.enabled:
            # Only here: the constant is imported by who serves nothing.
            from type_description_interfaces.srv import GetTypeDescription

            node._create_own_service(GetTypeDescription, "~/get_type_description", self._refuse)

    def _refuse(self, request: Any, response: Any) -> Any:
        response.successful = False
        response.failure_reason = "a simulated node describes no types"
        return response
