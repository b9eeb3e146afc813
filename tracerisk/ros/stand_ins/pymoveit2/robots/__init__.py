"""Names of joints, links and groups of robots, as pymoveit2 has them."""

from . import crane_x7, kinova, lbr, panda, phantomx_pincher, ur

__all__ = ["crane_x7", "kinova", "lbr", "panda", "phantomx_pincher", "ur"]
