"""Pose graph of the keyframes: iSAM2 while the camera moves, Levenberg-Marquardt over everything at the end
(Kaess et al., IJRR 2012; Dellaert and Kaess 2017). The only importer of GTSAM."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import gtsam
import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from slam.backend.resistance_network import ResistanceNetwork
from slam.pose_edge import INFORMATION, OPEN_INFORMATION, PoseEdge, PosePrior, edge_information

# Residuals of this many sigmas have lost most of their pull (Geman and McClure): a false closure bends nothing.
GEMAN_MCCLURE = 3.0
# What tracking measured holds the chain together and is never let go, but pulls the less the more others contradict it.
HUBER = 0.5
# Priors of poses from elsewhere pull no more strongly from this many sigmas on (Huber): where these jump, many
# registrations say otherwise and have their way, and a single one that slid along a wall has not.
PRIOR_HUBER = 2.0
ANCHOR_SIGMA = 1e-4  # of the keyframe that is the world: as good as fixed, and still invertible
UNANCHORED_SIGMA = 1e1  # of the first keyframe of a submap that no edge connects with the rest
LEAP_M = 1.0  # by which poses move at once, at most, if it is known that full steps did not diverge
UNKNOWN_M2 = 20.0  # variance of an edge that says nothing, by the least information that edges count with, and more
RELINEARISE = 0.005  # radians and metres by which a keyframe moves before its factors are linearised anew


@dataclass
class Batch:
    """What iSAM2 takes in at once: first guesses (4, 4) by keyframe, anchors as (keyframe, pose (4, 4), unanchored),
    edges, and priors."""

    guesses: dict[int, Float64Array] = field(default_factory=dict)
    anchors: list[tuple[int, Float64Array, bool]] = field(default_factory=list)
    edges: list[PoseEdge] = field(default_factory=list)
    priors: list[PosePrior] = field(default_factory=list)
    robust: bool = True  # whether edges pull the less the more others contradict them

    def problem(self) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
        """The same as GTSAM has it."""
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        for number, pose in self.guesses.items():
            values.insert(number, gtsam.Pose3(pose))
        edges = (_factor(edge, self.robust) for edge in self.edges)
        for factor in (*(_anchor(*anchor) for anchor in self.anchors), *edges, *map(_prior_factor, self.priors)):
            graph.add(factor)
        return graph, values


class PoseGraph:
    """Keyframes, numbered as they come: `poses` holds world_from_camera (4, 4) of each as known now.

    fixed: the keyframe that is the world; None = priors say where the world is."""

    def __init__(self, fixed: int | None = 0) -> None:
        self.edges: list[PoseEdge] = []
        self.priors: list[PosePrior] = []
        self.network = ResistanceNetwork()  # of them
        self._anchors: dict[int, Float64Array] = {}  # first keyframes of submaps, and the poses they are held at
        self._fixed = fixed
        self._restart()

    def _restart(self) -> None:
        self._isam = _isam2()
        self._taken: list[Batch] = []  # by iSAM2 since it was started
        self._new = Batch()
        self.poses: dict[int, Float64Array] = {}
        self._solved = np.zeros((0, 12))  # the poses that GTSAM gave last, row by row
        self._ends, self._is_odometry = np.zeros((0, 2), np.int64), np.zeros(0, bool)  # of edges

    @property
    def fixed(self) -> int | None:
        """The keyframe that is the world; None = priors say where the world is."""
        return self._fixed

    def edge_table(self) -> tuple[Int64Array, BoolArray]:
        """The keyframes (E, 2) that each edge joins, and whether it `is_odometry` (E,)."""
        new = self.edges[len(self._ends) :]
        if new:
            ends = np.array([(edge.a, edge.b) for edge in new], np.int64)
            self._ends = np.concatenate([self._ends, ends])
            self._is_odometry = np.concatenate([self._is_odometry, [edge.is_odometry for edge in new]])
        return self._ends, self._is_odometry

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in ("_isam", "network")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """iSAM2 is fed all that it was, in the same order."""
        vars(self).update(state, _isam=_isam2(), network=ResistanceNetwork())
        for edge in self.edges:
            self.network.add(edge.a, edge.b, edge.variance_m2)
        for batch in self._taken:
            self._update(batch)

    def add_keyframe(self, number: int, world_from_camera: Float64Array, unanchored: bool = False) -> None:
        """A further keyframe at its first guess; the first one is fixed there, an unanchored one hardly at all."""
        self._new.guesses[number] = world_from_camera
        if (not self.poses and number == self._fixed) or unanchored:
            self._anchors[number] = world_from_camera
            self._new.anchors.append((number, world_from_camera, unanchored))
        self.poses[number] = world_from_camera

    def add_edge(self, edge: PoseEdge) -> None:
        """A further measured motion between two keyframes."""
        self.edges.append(edge)
        self.network.add(edge.a, edge.b, edge.variance_m2)
        self._new.edges.append(edge)

    def add_prior(self, prior: PosePrior) -> None:
        """What poses from elsewhere say of a keyframe."""
        self.priors.append(prior)
        self._new.priors.append(prior)

    def doubt_edges(self) -> None:
        """Let edges that the present poses contradict count in the network by as much as they still pull."""
        self.network = ResistanceNetwork()
        for edge in self.edges:
            contradiction = 0.0 if edge.is_odometry else mahalanobis(edge, self.poses) / GEMAN_MCCLURE
            doubted = edge.variance_m2 * (1 + contradiction**2) ** 2
            self.network.add(edge.a, edge.b, min(doubted, UNKNOWN_M2))

    def optimise(self) -> Mapping[int, Float64Array]:
        """The poses of all keyframes after taking in what was added, by iSAM2."""
        try:
            self._update(self._new)
            estimate = self._isam.calculateEstimate()
        except RuntimeError:  # a step that GTSAM cannot solve
            return self._start_over()
        if self._leaps(estimate):
            return self._start_over()
        self._taken.append(self._new)
        self._new = Batch()
        return self._take_over(estimate)

    def _start_over(self) -> Mapping[int, Float64Array]:
        """By damped steps, which can be solved and do not diverge; iSAM2 goes on from where they lead."""
        self.smooth()
        self.replace(self.edges)
        return self.poses

    def _leaps(self, estimate: gtsam.Values) -> bool:
        """Whether a pose would move so far that the full steps of iSAM2 may have diverged."""
        rows = np.asarray(gtsam.utilities.extractPose3(estimate))
        moved_m = np.linalg.norm(rows[: len(self._solved), 9:] - self._solved[:, 9:], axis=1)
        return not np.isfinite(rows).all() or bool((moved_m > LEAP_M).any())

    def _take_over(self, estimate: gtsam.Values) -> Mapping[int, Float64Array]:
        """The poses of all keyframes, of which those that changed are new arrays."""
        rows = np.asarray(gtsam.utilities.extractPose3(estimate))  # by number: rotation row by row, shift
        known = len(self._solved)
        changed = np.flatnonzero((rows[:known] != self._solved).any(axis=1))
        numbers = list(estimate.keys())
        for row in (*changed.tolist(), *range(known, len(rows))):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = rows[row, :9].reshape(3, 3), rows[row, 9:]
            self.poses[numbers[row]] = pose
        self._solved = rows
        return self.poses

    def _update(self, batch: Batch) -> None:
        self._isam.update(*batch.problem())
        if any(not edge.is_odometry for edge in batch.edges):
            self._isam.update()  # once more from where the loop led; what tracking adds is at its optimum already

    def covariance(self, number: int) -> Float64Array | None:
        """The marginal covariance (6, 6) of a keyframe that was optimised: rotation and shift in its own axes; None
        where iSAM2 has none."""
        return _marginal(self._isam, number)

    def covariances(self, edges: Iterable[PoseEdge] | None = None) -> dict[int, Float64Array]:
        """The marginal covariances of all keyframes at the present poses, those that can be computed, by other `edges`
        whose errors are normal, and by priors' own sigmas; None = as edges and priors count."""
        isam = _isam2()
        try:
            isam.update(*(self._problem() if edges is None else self._normal_problem(edges)))
        except RuntimeError:
            return {}
        marginals = {number: _marginal(isam, number) for number in self.poses}
        return {number: marginal for number, marginal in marginals.items() if marginal is not None}

    def displacements(self, edges: Sequence[PoseEdge], others: Sequence[PoseEdge]) -> dict[int, Float64Array]:
        """By how much (6,), along its own axes, each keyframe moves from where `edges` put it to where `others` do, to
        first order; none where that cannot be computed."""
        try:
            before, after = (
                graph.linearize(values).optimize() for graph, values in map(self._normal_problem, (edges, others))
            )
        except RuntimeError:
            return {}
        return {number: np.asarray(after.at(number) - before.at(number)) for number in self.poses}

    def _normal_problem(self, edges: Iterable[PoseEdge]) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
        """The present poses under edges whose errors are normal, and priors with their own sigmas."""
        priors = [replace(prior, unit=1.0) for prior in self.priors]
        return Batch(self.poses, self._anchored(self._anchors), list(edges), priors, robust=False).problem()

    def smooth(self) -> Mapping[int, Float64Array]:
        """The poses of all keyframes from all edges at once (Levenberg-Marquardt)."""
        estimate = gtsam.LevenbergMarquardtOptimizer(*self._problem()).optimize()
        return self._take_over(estimate)

    def _problem(self) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
        return Batch(dict(self.poses), self._anchored(self._anchors), self.edges, self.priors).problem()

    def _anchored(self, keyframes: Iterable[int]) -> list[tuple[int, Float64Array, bool]]:
        return [(number, self._anchors[number], number != self._fixed) for number in keyframes]

    def shift(self, poses: Mapping[int, Float64Array]) -> None:
        """Start iSAM2 anew from other poses, as when an unanchored submap is merged with another."""
        self.poses = dict(poses)
        self._anchors = {number: self.poses[number] for number in self._anchors}
        self.replace(self.edges)

    def fix(self, number: int) -> None:
        """Let another keyframe, the first one of an unanchored submap, be the one whose pose is certain."""
        self._fixed = number
        self.shift(self.poses)

    def replace(self, edges: Iterable[PoseEdge], priors: Iterable[PosePrior] | None = None) -> None:
        """Start iSAM2 anew from the present poses with other edges, and with other priors, None = the same."""
        poses, edges = self.poses, list(edges)
        self.priors = list(self.priors if priors is None else priors)
        self.edges, self.network = [], ResistanceNetwork()
        self._restart()
        anchors = self._anchored(number for number in poses if number in self._anchors)
        self._new = Batch(dict(poses), anchors, priors=list(self.priors))
        self.poses = dict(poses)
        for edge in edges:
            self.add_edge(edge)


def mahalanobis(edge: PoseEdge, poses: Mapping[int, Float64Array]) -> float:
    """How many sigmas an edge differs from the given poses: its Mahalanobis distance."""
    measured = gtsam.Pose3(edge.a_from_b)
    predicted = gtsam.Pose3(np.linalg.inv(poses[edge.a]) @ poses[edge.b])
    error = np.asarray(measured.localCoordinates(predicted))
    return float(np.sqrt(max(float(error @ edge_information(edge) @ error), 0.0)))


def _isam2() -> gtsam.ISAM2:
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(RELINEARISE)
    parameters.relinearizeSkip = 1
    parameters.setFactorization("QR")  # slower than Cholesky's, and solves what is nearly singular
    return gtsam.ISAM2(parameters)


def _marginal(isam: gtsam.ISAM2, number: int) -> Float64Array | None:
    """Symmetric, whatever rounding did, and positive definite, or None: what GTSAM inverts may be all but singular."""
    try:
        marginal = np.asarray(isam.marginalCovariance(number))
    except (RuntimeError, IndexError):  # a step it cannot solve; a keyframe it was not given yet
        return None
    marginal = (marginal + marginal.T) / 2
    return marginal if np.isfinite(marginal).all() and np.linalg.eigvalsh(marginal)[0] > 0 else None


def _prior_factor(prior: PosePrior) -> gtsam.BetweenFactorPose3 | gtsam.PriorFactorPose3:
    kernel = gtsam.noiseModel.mEstimator.Huber.Create(PRIOR_HUBER * prior.unit)
    noise = gtsam.noiseModel.Robust.Create(kernel, gtsam.noiseModel.Diagonal.Sigmas(prior.sigmas / prior.unit))
    pose = gtsam.Pose3(prior.a_from_b)
    if prior.a is None:
        return gtsam.PriorFactorPose3(prior.b, pose, noise)
    return gtsam.BetweenFactorPose3(prior.a, prior.b, pose, noise)


def _factor(edge: PoseEdge, robust: bool) -> gtsam.BetweenFactorPose3:
    information = edge_information(edge, INFORMATION[0] if robust else OPEN_INFORMATION)
    noise: gtsam.noiseModel.Base = gtsam.noiseModel.Gaussian.Information(information)
    if robust:
        kernels = gtsam.noiseModel.mEstimator
        kernel = kernels.Huber.Create(HUBER) if edge.is_odometry else kernels.GemanMcClure.Create(GEMAN_MCCLURE)
        noise = gtsam.noiseModel.Robust.Create(kernel, noise)
    return gtsam.BetweenFactorPose3(edge.a, edge.b, gtsam.Pose3(edge.a_from_b), noise)


def _anchor(number: int, pose: Float64Array, unanchored: bool) -> gtsam.PriorFactorPose3:
    noise = gtsam.noiseModel.Isotropic.Sigma(6, UNANCHORED_SIGMA if unanchored else ANCHOR_SIGMA)
    return gtsam.PriorFactorPose3(number, gtsam.Pose3(pose), noise)
