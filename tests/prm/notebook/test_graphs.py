import builtins

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import FaultTree, HybridModel, MarkovChain
from tracerisk.prm.notebook.graphs import graph_of
from tracerisk.prm.trees.failure_models import Constant

TREE = FaultTree.of(
    "top",
    {"top": ("atleast", 2, "a", ("and", "b", "b"), "on")},
    {"a": 0.25, "b": None},
    {"on": True},
)


def test_a_fault_tree_is_a_graph_from_its_gates_to_their_inputs():
    nx = pytest.importorskip("networkx", reason="networkx is not installed")
    graph = TREE.to_networkx()
    assert graph.graph["top"] == "top"
    assert dict(graph.nodes["top"]) == {"kind": "atleast", "k": 2, "most": None}
    assert dict(graph.nodes["a"]) == {"kind": "event", "parameter": "a", "model": Constant(0.25)}
    assert dict(graph.nodes["on"]) == {"kind": "house", "state": True}
    assert list(graph.successors("top")) == ["a", "top.2", "on"]
    assert graph.edges["top.2", "b"] == {"rank": 0, "count": 2}
    assert nx.ancestors(graph, "b") == {"top", "top.2"}


def test_a_chain_is_a_graph_of_its_transitions():
    pytest.importorskip("networkx", reason="networkx is not installed")
    graph = MarkovChain.of({"a": {"a": 0.25, "end": 0.75}}).to_networkx()
    assert graph.edges["a", "end"]["probability"] == 0.75
    assert graph.nodes["end"]["kind"] == "absorbing"


def test_a_hybrid_model_is_a_graph_of_what_follows_and_what_fails():
    pytest.importorskip("networkx", reason="networkx is not installed")
    model = HybridModel.of(
        "arm", {"pick": TREE}, {"pick": {"pick": 0.75, "done": 0.25}}, values={"b": 0.5}
    )
    graph = model.to_networkx()
    assert graph.edges["pick", "done"]["weight"] == 0.25
    assert graph.nodes["pick_failure"]["kind"] == "failure"
    assert graph.nodes["pick"]["tree"] is TREE
    assert graph.graph == {"name": "arm", "entry": "pick"}


def test_without_networkx_the_extra_to_install_is_named(monkeypatch):
    real = builtins.__import__

    def refusing(name, *rest):
        if name == "networkx":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refusing)
    with pytest.raises(ModelError, match=r"install it with: pip install 'tracerisk\[graph\]'"):
        TREE.to_networkx()


def test_what_is_no_graph_is_refused():
    pytest.importorskip("networkx", reason="networkx is not installed")
    with pytest.raises(TypeError, match="str is not a graph"):
        graph_of("text")
