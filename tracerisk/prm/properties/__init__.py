"""What people ask of chains, in PRISM's property language: P, R and S."""

from tracerisk.prm.properties.answers import Answer, ask
from tracerisk.prm.properties.parser import parse_properties
from tracerisk.prm.properties.property import Property, PropertyFile

__all__ = ["Answer", "Property", "PropertyFile", "ask", "parse_properties"]
