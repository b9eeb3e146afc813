"""`tracerisk strip`: what becomes of the lock is said."""

from tests.pipeline.review.test_review import lock_of, write


def two(repository, annotated_source):
    source = annotated_source(place=("done 1", "gripper = 2e-07"))
    entries = [(name, lock_of({name: source}, name)) for name in ("a.py", "b.py")]
    write(repository, {"a.py": source, "b.py": source}, *entries)
    return repository


def test_the_lock_that_goes_with_its_last_controller_is_named(repository, annotated_source):
    cell = two(repository, annotated_source)
    first = cell.run("strip", "a.py")
    assert "tracerisk.lock: no longer knows a.py" in first.err
    assert (cell.folder / "tracerisk.lock").exists()
    last = cell.run("strip", "b.py")
    assert "tracerisk.lock: removed, for it knew no other controller" in last.err
    assert not (cell.folder / "tracerisk.lock").exists()


def test_nothing_is_said_of_a_lock_that_stays_as_it_is(repository, annotated_source):
    cell = two(repository, annotated_source)
    assert "tracerisk.lock" not in cell.run("strip", "a.py", "--check").err
    assert cell.run("strip", "a.py").code == 0
    assert "tracerisk.lock" not in cell.run("strip", "a.py").err
