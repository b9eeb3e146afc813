"""What people ask of chains, in PRISM's property language: P, R and S."""

from tracerisk.prm.other_models.properties.answers import Answer, ask
from tracerisk.prm.other_models.properties.parser import parse_properties
from tracerisk.prm.other_models.properties.property import Property, PropertyFile

__all__ = ["Answer", "Property", "PropertyFile", "ask", "parse_properties"]
