"""Layouts of the viewer: four tabs for a run, each for one kind of question; two runs side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import rerun.blueprint as rrb

from app.render.viewpoint import Viewpoint
from app.timeline import entities
from app.timeline.recording.rerun_log import FRAME

WHITE = (255, 255, 255)
LOG_COLUMNS = rrb.TextLogColumns(timeline_columns=[FRAME], text_log_columns=["LogLevel", "Body"])
OBJECT_COLUMNS = rrb.TextLogColumns(timeline_columns=[FRAME], text_log_columns=["EntityPath", "Body"])
ALL_BUT_DEBUG = rrb.TextLogRows(filter_by_log_level=["INFO", "WARN", "ERROR", "CRITICAL"])
LEGEND_BOUNDS = rrb.VisualBounds2D(x_range=(-2.0, 4.0), y_range=(-1.0, 13.0))  # rows of names below each other
OBJECTS_TITLE = "Objects: click on one for its figures (last button at the top)"
COLOR_WORDS = ("blue", "orange")
SIGMA_TITLE = "Position uncertainty, cm (diamond: loop closed, cross: lost)"
NO_LEGEND = rrb.PlotLegend(visible=False)


@dataclass(frozen=True)
class RunView:
    """What a layout depends on: eyes of the map, above the path, and of the objects; whether poses are estimated; the
    milliseconds where the plot of stages ends; objects that are hidden at first; the entity the run lies below."""

    eye: Viewpoint
    top: Viewpoint
    objects_eye: Viewpoint
    poses_estimated: bool = False
    clipped_ms: float | None = None
    hidden: tuple[str, ...] = ()
    root: str = ""

    def path(self, entity: str) -> str:
        """The full path of an entity."""
        return f"{self.root}/{entity}"

    def contents(self, *names: str) -> list[str]:
        """What a view shows: entities, and all below them."""
        return [f"+ {self.path(name)}/**" for name in names]


def run_layout(run: RunView) -> rrb.Blueprint:
    """The layout of a run: *Overview*, *Objects*, *Poses*, *Performance*."""
    tabs = rrb.Tabs(overview_tab(run), _objects_tab(run), _poses_tab(run), _performance_tab(run), active_tab=0)
    return _with_panels(tabs)


def pair_layout(runs: Sequence[tuple[str, RunView]]) -> rrb.Blueprint:
    """Runs side by side on one time axis: *Overview*, *Poses*, *Performance* of each beside those of the other."""
    overviews = rrb.Horizontal(
        *(rrb.Vertical(_map(run, name), _image(run), row_shares=[3, 2]) for name, run in runs), name="Overview"
    )
    shown = (entities.PATH, entities.ESTIMATED, entities.LOST, entities.FOUND)
    colors = ", ".join(f"{name} {color}" for (name, _), color in zip(runs, COLOR_WORDS, strict=False))
    above = rrb.Spatial3DView(
        origin="/", name=f"Paths from above: {colors}",
        contents=[line for _, run in runs for line in run.contents(*shown)],
        background=WHITE, line_grid=False, eye_controls=_eye(runs[0][1].top),
    )  # fmt: skip
    plots = [_uncertainty(run, f"{name}: position uncertainty, cm") for name, run in runs if run.poses_estimated]
    figures = rrb.TextDocumentView(origin=entities.FIGURES, name="Which poses are better")
    poses = rrb.Horizontal(above, rrb.Vertical(figures, *plots), column_shares=[3, 2], name="Poses")
    objects = rrb.Horizontal(*(_objects(run, name) for name, run in runs), name="Objects")
    performance = rrb.Horizontal(*(_stages(run, f"{name}: ms") for name, run in runs), name="Performance")
    return _with_panels(rrb.Tabs(overviews, objects, poses, performance, active_tab=0))


def scene_layout(view: Viewpoint) -> rrb.Blueprint:
    """One view of all there is, beside the tree in which each part can be shown and hidden."""
    return rrb.Blueprint(
        rrb.Spatial3DView(origin="/", name="Maps", line_grid=False, eye_controls=_eye(view)),
        rrb.BlueprintPanel(state="expanded"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed"),
        auto_views=False,
    )


def _with_panels(tabs: rrb.Tabs) -> rrb.Blueprint:
    return rrb.Blueprint(
        tabs,
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=FRAME, play_state="following"),
        auto_views=False,
    )


def overview_tab(run: RunView) -> rrb.Horizontal:
    """The map, what the camera sees, and the figures of the run."""
    card = rrb.TextDocumentView(origin=run.path(entities.SUMMARY), name="Summary")
    side = rrb.Vertical(_image(run), card, _instances(run), row_shares=[5, 4, 2])
    return rrb.Horizontal(_map(run, "Map"), side, column_shares=[3, 2], name="Overview")


def _instances(run: RunView) -> rrb.TimeSeriesView:
    # They grow, so that there is room below on the right.
    return rrb.TimeSeriesView(origin=run.path(entities.INSTANCES), name="Instances", plot_legend="RightBottom")


def _map(run: RunView, name: str) -> rrb.Spatial3DView:
    shown = (entities.SURFACE, entities.GROWING, entities.BOXES, entities.LABELS, entities.RECENT_PATH)
    return rrb.Spatial3DView(
        origin=run.path(""), name=name, contents=[*run.contents(*shown), *_camera(run)],
        background=WHITE, line_grid=False, eye_controls=_eye(run.eye),
    )  # fmt: skip


def _camera(run: RunView) -> list[str]:
    return [f"+ {run.path(entities.CAMERA)}", f"+ {run.path(entities.COLOR)}"]


def _image(run: RunView) -> rrb.Tabs:
    return rrb.Tabs(
        rrb.Spatial2DView(origin=run.path(entities.INSTANCE_IMAGE), name="What it sees"),
        rrb.Spatial2DView(origin=run.path(entities.COLOR), name="Colour"),
        rrb.Spatial2DView(origin=run.path(entities.DEPTH), name="Depth"),
    )


def _objects_tab(run: RunView) -> rrb.Horizontal:
    crops = rrb.Spatial2DView(origin=run.path(entities.CROPS), name="Best views")
    seen = rrb.TimeSeriesView(
        origin=run.path(entities.OBSERVATIONS), name="Times seen, each in its colour", plot_legend=NO_LEGEND
    )
    lives = rrb.TextDocumentView(origin=run.path(entities.LIVES), name="Lives of the objects")
    log = rrb.TextLogView(
        origin=run.path(entities.OBJECTS), name="Lives as a log", columns=OBJECT_COLUMNS, rows=ALL_BUT_DEBUG
    )
    events = rrb.TextLogView(
        origin=run.path(entities.EVENTS), name="All events", columns=LOG_COLUMNS, rows=ALL_BUT_DEBUG
    )
    frame = rrb.TextDocumentView(origin=run.path(entities.DECISIONS), name="This frame")
    objects = rrb.Vertical(_objects(run, OBJECTS_TITLE), rrb.Tabs(crops, seen), row_shares=[5, 3])
    return rrb.Horizontal(objects, rrb.Tabs(lives, log, events, frame), column_shares=[1, 1], name="Objects")


def _objects(run: RunView, name: str) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        origin=run.path(""), name=name, contents=run.contents(entities.OBJECTS, entities.OBJECT_LABELS),
        background=WHITE, line_grid=False, eye_controls=_eye(run.objects_eye),
        overrides={run.path(entity): rrb.EntityBehavior(visible=False) for entity in run.hidden},
    )  # fmt: skip


def _path_contents(run: RunView) -> list[str]:
    return [*run.contents("poses"), f"- {run.path(entities.RECENT_PATH)}"]


def _poses_tab(run: RunView) -> rrb.Horizontal:
    hidden = {
        run.path(entities.CLOSURES): rrb.EntityBehavior(visible=False),
        run.path(entities.ELLIPSOIDS): rrb.EntityBehavior(visible=False),
    }
    title = "Path from above" + (": given grey, estimated orange, corrections red" if run.poses_estimated else "")
    above = rrb.Spatial3DView(
        origin=run.path(""), name=title,
        contents=[*_path_contents(run), *run.contents(entities.SURFACE), *_camera(run)],
        overrides=hidden, background=WHITE, line_grid=False, eye_controls=_eye(run.top),
    )  # fmt: skip
    card = rrb.TextDocumentView(origin=run.path(entities.POSE_SUMMARY), name="In short")
    if not run.poses_estimated:
        return rrb.Horizontal(above, card, column_shares=[2, 1], name="Poses")
    log = rrb.TextLogView(
        origin=run.path(entities.POSE_EVENTS), name="Lost and found, closures, corrections", columns=LOG_COLUMNS
    )
    side = rrb.Vertical(card, _uncertainty(run, SIGMA_TITLE), log, row_shares=[2, 4, 4])
    return rrb.Horizontal(above, side, column_shares=[1, 1], name="Poses")


def _uncertainty(run: RunView, name: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(origin=run.path(entities.SIGMA), name=name, plot_legend=NO_LEGEND)


def _performance_tab(run: RunView) -> rrb.Vertical:
    legend = rrb.Spatial2DView(
        origin=run.path(entities.STAGE_LEGEND), name="Stages", background=WHITE, visual_bounds=LEGEND_BOUNDS
    )
    stages = rrb.Horizontal(_stages(run, "Milliseconds, stage upon stage"), legend, column_shares=[7, 1])
    memory = rrb.TimeSeriesView(origin=run.path(entities.MEMORY), name="Memory, MB", plot_legend="LeftTop")
    slow = rrb.TextLogView(origin=run.path(entities.SLOW_EVENTS), name="Slow frames, and why", columns=LOG_COLUMNS)
    below = rrb.Horizontal(memory, _instances(run), slow)
    return rrb.Vertical(stages, below, row_shares=[3, 2], name="Performance")


def _stages(run: RunView, name: str) -> rrb.TimeSeriesView:
    axis = None if run.clipped_ms is None else rrb.ScalarAxis(range=(0.0, run.clipped_ms))
    shown = [f"+ {run.path(entities.STAGES)}", f"+ {run.path(entities.SLOW)}"]
    return rrb.TimeSeriesView(origin=run.path("plots"), name=name, contents=shown, axis_y=axis, plot_legend=NO_LEGEND)


def _eye(view: Viewpoint) -> rrb.EyeControls3D:
    return rrb.EyeControls3D(position=view.position, look_target=view.target, eye_up=view.up)
