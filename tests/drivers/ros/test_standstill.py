"""What tells that an arm has arrived, stands elsewhere or still moves."""

from beltsort.drivers.ros.standstill import Motion, Standstill


def seen(*states: tuple[float, float]) -> list[Motion]:
    watch = Standstill({"elbow": 1.0}, tolerance=0.02, still=0.2, stalled=2.0)
    return [watch.see(time, {"elbow": at}) for time, at in states]


def test_passing_by_is_not_arriving() -> None:
    assert set(seen((0.0, 0.98), (0.1, 0.99), (0.2, 1.0), (0.3, 1.01), (0.4, 1.02))) == {Motion.MOVING}


def test_trembling_at_the_target_is_arriving() -> None:
    assert seen((0.0, 1.001), (0.1, 0.999), (0.2, 1.001))[-1] is Motion.ARRIVED


def test_creeping_is_moving() -> None:
    states = [(0.1 * n, 0.5 + 0.001 * n) for n in range(40)]
    assert Motion.ELSEWHERE not in seen(*states)


def test_standing_elsewhere_takes_longer_unless_the_motion_has_ended() -> None:
    *before, last = seen((0.0, 0.5), (0.9, 0.5), (1.8, 0.5), (2.0, 0.5))
    assert {*before} == {Motion.MOVING}
    assert last is Motion.ELSEWHERE
    watch = Standstill({"elbow": 1.0}, tolerance=0.02, still=0.2, stalled=2.0)
    watch.see(0.0, {"elbow": 0.5})
    watch.expect_no_more()
    assert watch.see(0.2, {"elbow": 0.5}) is Motion.ELSEWHERE


def test_a_silence_does_not_prove_that_the_arm_stood_still() -> None:
    assert seen((0.0, 0.5), (5.0, 0.5)) == [Motion.MOVING, Motion.MOVING]
