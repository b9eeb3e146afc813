"""The service that describes the interfaces of a node: its parameter; it is not served here."""

from __future__ import annotations

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"
