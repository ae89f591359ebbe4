"""Thresholds that decide about causes, each with its unit and its reason.

Values without another source were chosen on development rigs (clean and rough ones that no trial
scores) so that rigs without an effect raise no more alarms than the levels say.
"""

import dataclasses


@dataclasses.dataclass(frozen=True)
class FoldPolicy:
    """Rules by which recordings are put into groups that are left out together.

    Attributes:
        groups: wanted at least; with as many recordings each is one, otherwise they are cut into
            contiguous spans. Five give a t distribution with four degrees of freedom.
        periods: of the motion that a span lasts at least; shorter ones resemble their neighbours.
        fewest: groups below which recordings cannot tell one cause from another.
        least_periods: of the motion that a span lasts at least where there would be fewer groups:
            a period of a decay is unlike the next, since it swings less.
        agreeing: groups that agreed as noise would let them, as which counts what is known of a
            dispersion before any is asked: log likelihoods are divided by the misfit already. No
            more than there are groups to agree with one another.
        quantiles: of the distribution of a dispersion that a few groups tell, over which
            probabilities are averaged.
    """

    groups: int = 5
    periods: float = 4.0
    fewest: int = 3
    least_periods: float = 1.0
    agreeing: float = 4.0
    quantiles: int = 200


@dataclasses.dataclass(frozen=True)
class ConfirmPolicy:
    """Thresholds at which a cause is confirmed by the prediction of what was left out.

    Attributes:
        deviance, per_amplitude: fall of the left-out sum of squares, over the misfit of the better
            model, that a cause must bring; as twice a logarithm of likelihoods 16 is odds of 3000
            to one, for a catalogue of some forty effects about eighty to one.
        worse: part of what some groups gain that others may lose.
        harm: rise of the root mean square error over long windows that counts as worse.
        concentrated: part of what is known of a cause's amplitudes that one group tells, from which
            the models are fitted again without it, and, of a recording, from which halves of
            recordings are left out: what only one shows no other can predict.
        long: long windows over those of the fit.
    """

    deviance: float = 16.0
    per_amplitude: float = 4.0
    worse: float = 0.25
    harm: float = 1.02
    concentrated: float = 0.8
    long: float = 5.0


@dataclasses.dataclass(frozen=True)
class BackwardPolicy:
    """Thresholds at which an accepted cause is taken out again, or another takes its place.

    Attributes:
        deviance, per_amplitude: rise of the sum of squares over the misfit without the cause, the
            others refitted, below which it is not needed.
        sure: times that, by its linearisation, from which a cause is needed without a refit.
        rivals: effects that are tried in the place of each cause: the best of those whose chi^2/dof
            was less than `near` times that of the cause when it was accepted.
    """

    deviance: float = 16.0
    per_amplitude: float = 4.0
    sure: float = 10.0
    rivals: int = 2
    near: float = 2.0


@dataclasses.dataclass(frozen=True)
class StructurePolicy:
    """Thresholds from which readings count as deviating in a way that noise would not.

    Attributes:
        level: of the three tests of structure together, in the search for causes and of what they
            leave.
        alarm: of the same, below which the verdict is that there is a gap: a campaign without one
            raises an alarm once in forty.
        catalogue, free, misfit: parts of the level that belong to structure like the catalogue's,
            to structure of any kind, and to a misfit that is larger than the noise without any
            structure. The last is small, since the noise's level is an estimate; it is reached at
            three standard errors.
        colour: relative error of the spectral density of coloured noise, which is an estimate with
            two numbers; white noise is known better than any test here asks.
        rounding: how much the blocks may scatter beyond noise, as a ratio of variances, where
            readings are coarse. Their noise is drawn as it is, its size and what of it repeats, so
            that more says that something else is there. On rigs with nothing hidden it is 1 to 7;
            a hysteresis that took 2,600 of a sum of squares passed for rounding at 39.
        unpredicted: standard errors by which held-out recordings may exceed noise and the errors of
            the fitted numbers, where the fitted ones show no structure. Those errors are of a
            linearised model, so that only plain contradictions count: a spring that hardens by a
            thirtieth, seen in two runs of like amplitude, left the third at twenty.
        squares: times that a sum of squares is drawn where readings are coarse, for its scatter: a
            tenth or two of itself where bodies come to rest on few steps. It is then known to an
            eighth.
    """

    level: float = 0.05
    alarm: float = 0.025
    catalogue: float = 0.485
    free: float = 0.485
    misfit: float = 0.03
    colour: float = 0.3
    rounding: float = 10.0
    unpredicted: float = 5.0
    squares: int = 30

    @property
    def seen(self) -> float:
        """Level of the test in the catalogue's directions alone."""
        return self.catalogue * self.level

    @property
    def left(self) -> float:
        """Level of the test of any structure alone."""
        return self.free * self.level


@dataclasses.dataclass(frozen=True)
class VerdictPolicy:
    """Thresholds from which a gap counts as explained, and a cause is offered.

    Attributes:
        excess: standard errors by which something is beyond the noise.
        probability: of each cause with its ties, at least.
        offered: the same, for a cause to be listed at all; less is a candidate.
        left: part of the noise's variance that may be left of a large gap where its structure is
            still seen; a tenth raises the error by five per cent.
        gone: lower end of the interval of shrink from which a gap counts as large.
        worse: rise of the held-out error with the causes that makes the model a worse one.
    """

    excess: float = 3.0
    probability: float = 0.9
    offered: float = 0.5
    left: float = 0.1
    gone: float = 0.95
    worse: float = 1.02


@dataclasses.dataclass(frozen=True)
class NoisePolicy:
    """Thresholds at which what a model leaves is asked for the noise.

    Attributes:
        level: relative change of a standard deviation, and
        correlation: change of the correlation of neighbours, and
        slow: ratio of what slowness adds to the error of a mean, up to which the noise that causes
            leave is the one they were chosen under: a choice anew would only throw the dice of what
            is nearly tied again.
        below: chi^2/dof of the baseline, under the noise that the data alone show, from which its
            residuals are not asked before causes are in: a rest so large is gap for the most part,
            which would pass for very slow noise. Slow noise of nine tenths of the variance, in
            addition to a tenth that the data show, is as large.
    """

    level: float = 0.05
    correlation: float = 0.05
    slow: float = 1.15
    below: float = 10.0


@dataclasses.dataclass(frozen=True)
class HorizonPolicy:
    """Lengths of the windows over which a choice is made.

    Attributes:
        below: chi^2/dof of a model with a cause from which windows are made longer: what is still
            missing then shows over longer times, and a wrong model has no way downhill there.
        factor: by which, after each accepted cause.
        looks: at decays over windows so many times longer each, before nothing is said to be there:
            what takes little energy in a period shows over many.
    """

    below: float = 3.0
    factor: float = 3.0
    looks: int = 2


@dataclasses.dataclass(frozen=True)
class LearningPolicy:
    """Thresholds at which a curve is asked for where no formula explains the gap.

    Attributes:
        refitted: laws that are refitted each time, those with the largest evidence; a refit of
            twelve coefficients takes as long as those of four formulas.
        deviance: sum of squares beyond the noise, over the misfit, from which a curve is asked for:
            as much as a cause of twelve amplitudes has to take (`earned`).
        chance: standard deviations of a sum of squares of noise alone up to which nothing is left.
        part: of what the best formula leaves beyond the noise that a law may leave to be taken
            before a second formula is sought: more may be what both leave to the friction's
            smoothing.
        rest: part of the gap that the best formula may leave before a law is asked first. Of many
            samples even a hundredth of a large gap is far above the noise, and it may be what the
            friction's smoothing does; what is really there is sought in addition to that formula.
        outside: part of the held-out samples beyond a curve's range from which a note says so; a
            run overshoots those beside it by a sample or two.
        elsewhere: part of the held-out recording's samples beyond it from which another recording
            is held out instead and all begins anew, which takes twice the time; a run that goes
            further for less than a twentieth of its time is still a test of the rest.
    """

    refitted: int = 2
    deviance: float = 64.0
    chance: float = 3.0
    part: float = 0.5
    rest: float = 0.01
    outside: float = 0.01
    elsewhere: float = 0.05


@dataclasses.dataclass(frozen=True)
class ExplorePolicy:
    """Rules for the run that is recorded next, and for when another one is not worth it.

    Attributes:
        probability: of the first cause from which it counts as known: odds of nineteen to one.
        rival: probability from which another effect counts as a rival: five such effects together
            could keep the first cause from `probability`.
        rivals: effects at most from which a run is to tell the first cause; each costs a
            linearisation of all runs that may come next.
        log_evidence: expected difference of log evidences [nat] below which a run is not worth
            recording: it would turn even odds into nineteen to one, about `probability`.
        enough: difference [nat] beyond which more does not count: a rival with one chance in four
            hundred needs no further run.
        survey: runs before any run is refused: a decay, and drives at two frequencies, since many
            effects show in one of them alone.
        nothing: runs before "nothing is left" is believed: drives at four frequencies and a decay
            reach the resonance from both sides. After three, effects that a sweep of six shows were
            given up on three of eight virtual rigs.
        margin: part of the limit up to which predicted angles are allowed; the model that predicts
            them lacks something still.
        frequencies: of the drive that are compared, and
        releases: angles of a free decay that are compared; so many that their forecasts take a few
            seconds.
        slowest, fastest: frequencies of the drive, of the natural frequency of both bodies
            together: the rider slides about resonance, and rests on the column far from it.
        least_release, largest_release: of a free decay [rad]: most riders stay in place below, and
            angles beyond leave the range in which two bridges tell the quarter turns.
        first_release: of the first decay [rad], from which most riders slide.
        longer: times a run's duration up to which a longer run is advised; motors and sensors warm
            up in longer ones.
    """

    probability: float = 0.95
    rival: float = 0.01
    rivals: int = 3
    log_evidence: float = 3.0
    enough: float = 6.0
    survey: int = 3
    nothing: int = 5
    margin: float = 0.9
    frequencies: int = 8
    releases: int = 5
    slowest: float = 0.4
    fastest: float = 1.35
    least_release: float = 0.2
    largest_release: float = 1.2
    first_release: float = 0.6
    longer: float = 20.0


@dataclasses.dataclass(frozen=True)
class SharedPolicy:
    """Thresholds at which an effect counts as shared by the rigs of a fleet.

    Attributes:
        level: probability of naming any effect of the catalogue where no rig has one. A fifth of
            that for a single rig, since a fleet is asked once and all its rigs are mended by it;
            twelve rigs with half the detectable size are ten times as far from chance.
        rigs: that an effect must apply to, and a fleet must have: of two that differ nobody knows
            which is usual.
        differ: level at which rigs are said to differ in an amplitude, the usual one: where that is
            wrong, an effect is only not called the kind's; and
        spread: standard deviation of their amplitudes, over the pooled one, from which that
            matters: with less, nearly all rigs have the effect with the same sign. Large effects
            are known so well that their linearisation alone makes them differ.
        alike: |cos| between an effect and a rig's own cause, on that rig, above which the cause is
            not projected out of the effect there: about half of what the rig says of the effect
            would go, and a rig may have named the kind's effect wrongly.
        kept: part of the reduction that is left without the rig that contributes most, if the
            effect does not pass without it; of three equal rigs two thirds are left.
        least: part of the largest reduction below which nothing further is named: linearisations
            of an effect are not good to a twentieth.
        near: -log p [nat] by which an effect is at most further from chance than another, for both
            not to be told apart; odds of nineteen to one.
        most: effects that are named of one fleet; more are beyond a linearisation at none of them.
        draws: of scores of noise alone; a p of `level` has a standard error of a fifth of it.
    """

    level: float = 0.01
    rigs: int = 3
    differ: float = 0.05
    spread: float = 0.5
    alike: float = 0.7
    kept: float = 0.5
    least: float = 0.05
    near: float = 3.0
    most: int = 6
    draws: int = 2000


@dataclasses.dataclass(frozen=True)
class Policy:
    """All of them."""

    folds: FoldPolicy = FoldPolicy()
    confirm: ConfirmPolicy = ConfirmPolicy()
    backward: BackwardPolicy = BackwardPolicy()
    structure: StructurePolicy = StructurePolicy()
    verdict: VerdictPolicy = VerdictPolicy()
    noise: NoisePolicy = NoisePolicy()
    horizon: HorizonPolicy = HorizonPolicy()
    learning: LearningPolicy = LearningPolicy()
    explore: ExplorePolicy = ExplorePolicy()
    shared: SharedPolicy = SharedPolicy()


POLICY = Policy()
