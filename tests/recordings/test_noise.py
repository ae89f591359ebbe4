"""The noise level is found under motion, kinks, rounding and jitter."""

import numpy as np
import pytest

from tp_jax.recordings import noise_level, noise_levels

T = 0.004 * np.arange(2500)
SINE = 0.5 * np.sin(6.0 * np.pi * T)

MOTIONS = {
    "rest": 0.0 * T,
    "sine": SINE,
    "kinked acceleration": 0.5 * np.abs(np.sin(6.0 * np.pi * T)) * np.sin(6.0 * np.pi * T),
    "kinked velocity": SINE + 0.02 * np.abs(np.sin(6.0 * np.pi * T + 0.3)),
    "winding": SINE + 50.0 * T,
    "start": SINE * (T > 0.5),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("sigma", [1e-4, 1e-3, 1e-2])
def test_white_noise(motion, sigma):
    # the mean of four, since one level has a sampling error of 2.5 %
    levels = [
        noise_level(T, MOTIONS[motion] + sigma * np.random.default_rng(i).standard_normal(T.size))
        for i in range(4)
    ]
    # 22 % of the highest differences meet a jump of the velocity, which no friction makes
    allowed = 0.08 if motion == "kinked velocity" else 0.05
    assert np.mean(levels) == pytest.approx(sigma, rel=allowed)


def test_one_recording_within_five_per_cent():
    noisy = MOTIONS["kinked acceleration"] + 1e-3 * np.random.default_rng(7).standard_normal(T.size)
    assert noise_level(T, noisy) == pytest.approx(1e-3, rel=0.05)


def test_jitter_lets_no_motion_through():
    random = np.random.default_rng(0)
    t = T + 4e-4 * random.uniform(-1.0, 1.0, T.size)
    y = 0.5 * np.sin(6.0 * np.pi * t) + 1e-3 * random.standard_normal(T.size)
    assert noise_level(t, y) == pytest.approx(1e-3, rel=0.06)


def test_twenty_samples_a_period_need_a_high_order():
    t = 0.1 * np.arange(4000)
    y = 2.0 * np.sin(np.pi * t) + 3e-3 * np.random.default_rng(0).standard_normal(t.size)
    assert noise_level(t, y) == pytest.approx(3e-3, rel=0.05)


def test_rounding_counts_as_noise():
    t = 0.1 * np.arange(4000)
    y = 0.0109 * np.round(2.0 * np.sin(2.9 * t) / 0.0109)
    assert noise_level(t, y) == pytest.approx(0.0109 / np.sqrt(12.0), rel=0.05)


def test_stuck_reading_has_the_noise_of_its_rounding():
    # slow, coarse: nine readings in ten repeat the one before
    y = 0.01 * np.round(0.5 * np.sin(0.2 * T) / 0.01)
    assert noise_level(T, y) == pytest.approx(0.01 / np.sqrt(12.0))


def test_a_body_at_rest_that_is_read_coarsely_keeps_its_noise():
    """Most second differences vanish, but for the last digits of a reading that is no round number.

    A swing that dies out under noise of .33 steps: its level once came out as that of rounding.
    """
    t = np.arange(3000) / 314.0
    step, sigma = 2.0 * np.pi / 8192, 0.33
    motion = 0.3 * np.exp(-4.0 * t) * np.cos(33.0 * t) - 10.0 * step
    y = step * np.round(motion / step + sigma * np.random.default_rng(2).normal(size=t.size))
    assert noise_level(t, y) == pytest.approx(y[1500:].std(), rel=0.05)


@pytest.mark.parametrize("step", [0.0, 1e-3])
def test_spikes_in_one_sample_of_ten_do_not_matter(step):
    """Whether or not the readings come in steps."""
    rng = np.random.default_rng(3)
    y = SINE + 1e-3 * rng.standard_normal(T.size)
    hit = rng.random(T.size) < 0.1
    y[hit] += 0.03 * rng.choice([-1.0, 1.0], size=hit.sum())
    y = step * np.round(y / step) if step else y
    level = np.hypot(1e-3, step / np.sqrt(12.0))
    assert noise_level(T, y) == pytest.approx(level, rel=0.15)


def test_single_jumps_do_not_matter():
    y = SINE + 1e-3 * np.random.default_rng(0).standard_normal(T.size)
    y[[100, 900, 2000]] += 0.3
    assert noise_level(T, y) == pytest.approx(1e-3, rel=0.05)


def test_gaps_do_not_look_like_noise():
    # every thirtieth step is a jump of half a period, and the ring comes back on another branch
    gaps = (np.arange(T.size) + 29) // 30
    t = T + gaps / 6.0
    y = 0.5 * np.sin(6.0 * np.pi * t) + np.pi * np.random.default_rng(1).integers(-3, 4, 85)[gaps]
    y += 1e-3 * np.random.default_rng(0).standard_normal(T.size)
    assert noise_level(t, y) == pytest.approx(1e-3, rel=0.06)


def test_stretches_of_a_few_samples_are_not_used():
    y = SINE + 1e-3 * np.random.default_rng(0).standard_normal(T.size)
    t = T.copy()
    t[-3:] += 1.0
    spoilt = np.append(y[:-3], [9.0, -9.0, 9.0])
    assert noise_level(t, spoilt) == pytest.approx(noise_level(T[:-3], y[:-3]), rel=1e-12)


def test_constant_has_none():
    assert noise_level(T, np.full(T.size, 0.3)) == 0.0


def test_too_few_samples():
    with pytest.raises(ValueError, match="needs 4 samples or more, but there are 3"):
        noise_level(T[:3], SINE[:3])


def noisy(seed, sigma, step=1):
    """Readings at every `step`-th time."""
    e = np.random.default_rng(seed).standard_normal(T.size)
    return T[::step], (SINE + sigma * e)[::step]


def runs(recording, *levels, steps=None):
    steps = steps or [1] * len(levels)
    made = [noisy(i, x, step) for i, (x, step) in enumerate(zip(levels, steps, strict=True))]
    return [recording(t=t, phi1=y, phi2=None) for t, y in made]


def test_recordings_of_one_kind_share_a_level(recording):
    found = noise_levels(runs(recording, *[1e-3] * 6))
    assert np.ptp(found[:, 0]) == 0.0
    assert found[0, 0] == pytest.approx(1e-3, rel=0.03)
    assert (found[:, 1] == 0.0).all()  # there is no rider


def test_a_channel_that_stood_still_says_nothing_of_its_noise(recording):
    """A coarse reading of a rider that stuck, in most recordings."""
    still, moving = np.zeros(T.size), noisy(3, 2e-3)[1]
    made = [recording(t=T, phi1=moving, phi2=y) for y in (still, still, moving)]
    np.testing.assert_allclose(noise_levels(made)[:, 1], 2e-3, rtol=0.1)
    assert (noise_levels(made[:2])[:, 1] == 0.0).all()


def test_a_recording_of_clearly_another_level_has_its_own(recording):
    found = noise_levels(runs(recording, 1e-3, 2e-3, 1e-3, 1e-3, 2e-3, 1e-3))[:, 0]
    expected = 1e-3 * np.array([1.0, 2.0, 1.0, 1.0, 2.0, 1.0])
    np.testing.assert_allclose(found, expected, rtol=0.06)


def test_recordings_of_other_rates_have_levels_of_their_own(recording):
    """As means over blocks have, which average the noise away."""
    found = noise_levels(runs(recording, 1e-3, 0.5e-3, 1e-3, 0.5e-3, steps=[1, 3, 1, 3]))[:, 0]
    np.testing.assert_allclose(found, [1e-3, 0.5e-3, 1e-3, 0.5e-3], rtol=0.06)
    assert found[0] == found[2]
    assert found[1] == found[3]


def test_where_an_angle_stands_between_two_steps_makes_no_noise_of_its_own(recording):
    """Rounding a body that hardly moves makes half a step of noise at an edge, none in a middle."""
    step, sigma = 6e-3, 1.3e-3
    rng = np.random.default_rng(3)
    runs = []
    for i, place in enumerate((0.5, 0.0, 0.25, 0.5, 0.1, 0.4, 0.0)):  # steps
        noise = (20e-3 if i == 6 else sigma) * rng.standard_normal(T.size)
        phi2 = step * np.round((place * step + 1e-4 * SINE + noise) / step)
        runs.append(recording(phi1=SINE + 1e-3 * rng.standard_normal(T.size), phi2=phi2))
    own = [noise_level(r.t, r.phi2) for r in runs[:-1]]
    assert max(own) > 1.3 * min(own)
    found = noise_levels(runs)[:, 1]
    assert len({*found[:-1]}) == 1
    assert found[-1] == pytest.approx(20e-3, rel=0.1)
