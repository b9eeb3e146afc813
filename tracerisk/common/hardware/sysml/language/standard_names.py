"""The names that are known without reading their files: ours, and the official libraries'."""

from __future__ import annotations

from dataclasses import dataclass

OURS = "TraceriskHardware"
"""The package that declares our metadata, `library/TraceriskHardware.sysml`."""

FEATURES: dict[str, tuple[str, ...]] = {
    "FailureData": (
        "probability",
        "rate",
        "weibull",
        "mtbf",
        "mttf",
        "mttfd",
        "b10",
        "b10d",
        "cycles",
        "dangerous",
        "temperature",
        "per",
        "demand",
        "standby",
        "errorFactor",
        "valueIs",
        "source",
        "age",
        "loadLaw",
    ),
    "FailureMode": ("fraction", "uses", "fault", "lasts", "source"),
    "HardwareData": ("robot", "exposureErrorFactor", "lot", "source"),
    "Redundancy": (
        "redundant",
        "required",
        "spare",
        "dormancy",
        "switch",
        "commonCause",
        "detected",
        "testInterval",
        "repairTime",
        "repairRate",
        "repairInMission",
    ),
    "TwinBinding": (
        "joints",
        "actuators",
        "gripper",
        "sensors",
        "sensorKind",
        "contacts",
        "optional",
        "always",
    ),
    "LoadLaw": ("referenceLoad", "wearingShare", "exponent", "referenceSpeed", "source"),
    "Weibull": ("shape", "characteristicLife"),
    "Temperature": ("rated", "working", "activationEnergy"),
}
"""The features of our metadata, and of the values within them."""


def _words(*meanings: str) -> dict[str, str]:
    """Return what the words of an enumeration mean: `missionStart` is `mission_start`."""
    words = {}
    for meaning in meanings:
        first, *others = meaning.split("_")
        words["".join((first, *map(str.title, others)))] = meaning
    return words


ENUMERATIONS: dict[str, dict[str, str]] = {
    "Basis": _words("visit", "demand", "minute", "hour"),
    "Statistic": _words("median", "mean"),
    "Spare": _words("hot", "warm", "cold"),
    "Detection": _words("mission_start", "each_visit"),
    "SensorKind": _words("encoder", "torque", "wrench", "camera"),
    "Fault": _words(
        *("dead", "jam", "offset", "frozen", "absent", "noisy", "no_force", "opens", "stuck")
    ),
    "Use": _words("moving", "holding", "grasping", "start", "grasp", "release"),
}
"""The words of our enumerations, and what the hardware description calls them."""

RISK = "RiskMetadata"
"""The official package of `@Risk`."""
LEVELS = ("low", "medium", "high")
RISK_FEATURES: dict[str, tuple[str, ...]] = {
    "Risk": ("totalRisk", "technicalRisk", "scheduleRisk", "costRisk"),
    "RiskLevel": ("probability", "impact"),
}

TIME_UNITS = {"s": 1.0, "second": 1.0, "min": 60.0, "minute": 60.0, "h": 3600.0, "hour": 3600.0}
TIME_UNITS |= {"d": 86400.0, "day": 86400.0}
"""The units of time of `SI` that are understood [s]."""

_CLOSED: dict[str, dict[str, tuple[str, ...]]] = {
    OURS: {
        **dict.fromkeys(FEATURES, ()),
        **{name: tuple(words) for name, words in ENUMERATIONS.items()},
        "FIT": (),
    },
    RISK: {
        **dict.fromkeys(RISK_FEATURES, ()),
        "Level": (),
        "LevelEnum": LEVELS,
        "RiskLevelEnum": LEVELS,
    },
}
"""Packages of which every name is known, with the names within these."""

OFFICIAL = frozenset(
    """
    Actions Allocations AnalysisCases AnalysisTooling Attributes Base BaseFunctions
    BooleanFunctions Calculations Cases CausationConnections CauseAndEffect Clocks
    CollectionFunctions Collections ComplexFunctions Connections Constraints ControlFunctions
    ControlPerformances DataFunctions DerivationConnections FeatureReferencingPerformances Flows
    ISQ ISQAcoustics ISQAtomicNuclear ISQBase ISQCharacteristicNumbers ISQChemistryMolecular
    ISQCondensedMatter ISQElectromagnetism ISQInformation ISQLight ISQMechanics ISQSpaceTime
    ISQThermodynamics ImageMetadata IntegerFunctions Interfaces Items KerML Links
    MeasurementRefCalculations MeasurementReferences Metadata Metaobjects ModelingMetadata
    NaturalFunctions NumericalFunctions Objects Observation OccurrenceFunctions Occurrences
    ParametersOfInterestMetadata Parts Performances Ports Quantities QuantityCalculations
    RationalFunctions RealFunctions RequirementDerivation Requirements SI SIPrefixes
    SampledFunctions ScalarFunctions ScalarValues SequenceFunctions ShapeItems SpatialFrames
    SpatialItems StandardViewDefinitions StatePerformances StateSpaceRepresentation States
    StringFunctions SysML TensorCalculations Time TradeStudies Transfers TransitionPerformances
    TrigFunctions Triggers USCustomaryUnits UseCases VectorCalculations VectorFunctions
    VectorValues VerificationCases Views
    """.split()  # noqa: SIM905
)
"""The other packages of the official libraries; any name in them is taken to exist."""

WITH_METADATA = frozenset(
    {"AnalysisTooling", "CauseAndEffect", "CausationConnections", "DerivationConnections"}
    | {"ImageMetadata", "Metadata", "ModelingMetadata", "ParametersOfInterestMetadata"}
    | {"RequirementDerivation", "SysML"}
)
"""Those of the official packages that may define metadata."""
WITH_PARTS = frozenset(
    {"Base", "Collections", "Items", "Objects", "Occurrences", "Parts", "ShapeItems"}
    | {"SpatialItems", "StandardViewDefinitions", "Time"}
)
"""Those of the official packages that may define what a part can be of."""

OF_ITEMS = frozenset(
    """
    boundingShapes done endShot envelopingShapes incomingTransferSort innerSpaceOccurrences
    isSolid localClock portions self shape snapshots spaceBoundary start startShot subitems
    suboccurrences subobjects subparts this timeSlices voids
    """.split()  # noqa: SIM905
)
"""What every part and item has, from `Items::Item`, `Objects::Object` and
`Occurrences::Occurrence` of the official libraries, as far as models refer to it."""

_SCALARS = frozenset(
    """
    Boolean Complex Integer Natural Number NumericalValue Positive Rational Real ScalarValue
    String
    """.split()  # noqa: SIM905
)


@dataclass(frozen=True, slots=True)
class Standard:
    """An element of a library that is known by its name."""

    path: tuple[str, ...]
    """The names from the library package to the element, such as `("SI", "h")`."""

    def __str__(self) -> str:
        return "::".join(self.path)

    def member(self, name: str) -> Standard | None:
        """Return what the element calls `name`, `None` where it is known to have no such."""
        package = self.path[0]
        known = _CLOSED.get(package)
        if known is not None:
            allowed = known if len(self.path) == 1 else known.get(self.path[1], ())
            if len(self.path) > 2 or name not in allowed:
                return None
        elif package == "ScalarValues" and name not in _SCALARS:
            return None
        elif package == "SI" and len(self.path) == 1 and name in ("one", *TIME_UNITS):
            return Standard(("SI", name))
        return Standard((*self.path, name))

    def offers(self, name: str) -> bool:
        """Whether an import of all names in the element is sure to bring `name`."""
        if self.path[0] in _CLOSED:
            return self.member(name) is not None
        if self.path[0] == "ScalarValues":
            return name in _SCALARS
        return self.path == ("SI",) and name in ("one", *TIME_UNITS)

    @property
    def is_closed(self) -> bool:
        """Whether every name in the element is known."""
        return self.path[0] in _CLOSED or self.path[0] == "ScalarValues"


def standard_package(name: str) -> Standard | None:
    """Return the library package of this name, if there is one."""
    return Standard((name,)) if name in _CLOSED or name in OFFICIAL else None


def known_members(path: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names that a library element is known to have, for messages."""
    known = _CLOSED.get(path[0], {})
    return tuple(known) if len(path) == 1 else tuple(known.get(path[1], ()))
