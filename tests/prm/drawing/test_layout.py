from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from tracerisk.prm.drawing.layout import Size, layered

names = [f"n{index}" for index in range(10)]
graphs = st.lists(st.tuples(st.sampled_from(names), st.sampled_from(names)), max_size=25)


@given(edges=graphs, widths=st.lists(st.floats(10, 200), min_size=10, max_size=10))
def test_nodes_never_overlap_and_every_edge_has_a_way(edges, widths):
    sizes = {name: Size(width, 30.0) for name, width in zip(names, widths, strict=True)}
    layout = layered(sizes, edges, gap=10.0, between=20.0)
    assert set(layout.centres) == set(names)
    for a, b in combinations(names, 2):
        (x, y), (u, v) = layout.centres[a], layout.centres[b]
        apart = (sizes[a].width + sizes[b].width) / 2 + 10.0
        assert abs(x - u) >= apart - 1e-6 or abs(y - v) >= 50.0 - 1e-6
    assert set(layout.ways) == {edge for edge in edges if edge[0] != edge[1]}
    for (a, b), way in layout.ways.items():
        assert (way[0], way[-1]) == (layout.centres[a], layout.centres[b])
    for name, (x, y) in layout.centres.items():
        assert x - sizes[name].width / 2 >= -1e-6
        assert x + sizes[name].width / 2 <= layout.width + 1e-6
        assert 15.0 <= y <= layout.height - 15.0


@given(edges=graphs)
def test_edges_of_a_graph_without_cycles_lead_downwards(edges):
    downward = [(a, b) for a, b in edges if a < b]
    layout = layered(dict.fromkeys(names, Size(20.0, 20.0)), downward)
    for a, b in set(downward):
        assert layout.centres[a][1] < layout.centres[b][1]


def test_children_stand_in_their_order_below_the_middle_of_their_parent():
    sizes = dict.fromkeys(["top", "c", "a", "b", "under"], Size(20.0, 20.0))
    layout = layered(sizes, [("top", "c"), ("top", "a"), ("top", "b"), ("b", "under")])
    x = {name: at for name, (at, _) in layout.centres.items()}
    assert x["c"] < x["a"] < x["b"]
    assert x["top"] == x["a"]


def test_lines_cross_no_more_than_they_must():
    sizes = dict.fromkeys(["l", "r", "x", "y"], Size(20.0, 20.0))
    layout = layered(sizes, [("l", "x"), ("l", "y"), ("r", "x")])
    x = {name: at for name, (at, _) in layout.centres.items()}
    assert (x["l"] < x["r"]) == (x["y"] < x["x"])


def test_nothing_at_all_has_no_extent():
    layout = layered({}, [])
    assert (layout.width, layout.height) == (0.0, 0.0)
