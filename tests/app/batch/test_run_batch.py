"""The rules of a batch, with an engine that maps nothing: order, attempts, memory, what is reported, going on."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from app.batch.begin import BatchPlan, begin, run_words
from app.batch.estimate import Estimator, RecordingSize
from app.batch.one_scene import SceneTask
from app.batch.report import BatchReport, begun_report
from app.batch.scenes import scenes_of
from app.console.streams import PlainConsole
from app.engines.task import Needs, Outcome
from app.object_store.place import Place
from app.settings.options import RunOptions
from razer.errors import BadInput

Answer = Callable[[SceneTask], Outcome]


def ended(task: SceneTask, *what: str, **more: object) -> Outcome:
    return Outcome(task.name, *what, **more)


def made(task: SceneTask) -> Outcome:
    """A run folder is there."""
    out = Path(task.out)
    out.mkdir(parents=True)
    for name in ("instances.json", "mesh.ply"):
        (out / name).write_text("")
    return ended(task, seconds=20.0, cpu_s=30.0, peak_mb=1000.0, node="here")


class ScriptedEngine:
    """One scene after the other, each answered as the test says."""

    def __init__(self, answer: Answer) -> None:
        self.answer, self.tasks, self.most = answer, list[SceneTask](), Needs(8, 16_000)
        self._open: list[SceneTask] = []
        self.is_closed = False

    def has_room(self, needs: Needs) -> bool:
        return not self._open

    def submit(self, task: SceneTask) -> None:
        self.tasks.append(task)
        self._open.append(task)

    def wait(self, timeout_s: float) -> list[Outcome]:
        return [self.answer(self._open.pop())] if self._open else []

    def close(self) -> None:
        self.is_closed = True


def recordings(folder: Path, **n_frames: int) -> Path:
    for name, count in n_frames.items():
        for kind in ("color", "depth"):
            (folder / name / kind).mkdir(parents=True)
            for index in range(count):
                (folder / name / kind / f"{index:06d}.png").write_bytes(b"x")
        (folder / name / "intrinsics.json").write_text("{}")
    return folder


def run(folder: Path, out: Path, answer: Answer, *, resume: bool = False, **options: object) -> tuple:
    engine = ScriptedEngine(answer)
    plan = BatchPlan.of(RunOptions(**options), None)
    console = PlainConsole(quiet=True)
    batch, report = begin(scenes_of(str(folder)), Place(str(out)), plan, lambda: engine, console, resume=resume)
    try:
        batch.run()
    finally:
        assert engine.is_closed
        written = json.loads((out / "report.json").read_text())
    return engine.tasks, report, written


def test_the_longest_comes_first_and_all_is_reported(tmp_path):
    folder = recordings(tmp_path / "scans", short=3, long=40, middle=20)
    tasks, _, written = run(folder, tmp_path / "out", made, stride=2)
    assert [task.name for task in tasks] == ["long", "middle", "short"]
    assert tasks[0].words == ("--stride=2",)
    assert {"format", "settings", "scenes", "totals"} == written.keys()
    entry = written["scenes"][0]
    assert entry["name"] == "long"
    assert (entry["status"], entry["attempts"], entry["seconds"], entry["cpu_s"]) == ("done", 1, 20.0, 30.0)
    assert (entry["peak_mb"], entry["node"], entry["reason"]) == (1000.0, "here", "")
    assert (written["totals"]["done"], written["totals"]["scenes"]) == (3, 3)


def test_a_poisoned_scene_is_named_and_harms_no_other(tmp_path):
    folder = recordings(tmp_path / "scans", a=9, poison=8, b=7)

    def answer(task: SceneTask) -> Outcome:
        return ended(task, "no camera poses", "none", log="razer: no") if task.name == "poison" else made(task)

    tasks, report, written = run(folder, tmp_path / "out", answer)
    assert [task.name for task in tasks] == ["a", "poison", "b"]
    assert report.n_failed == 1
    status = {entry["name"]: (entry["status"], entry["reason"]) for entry in written["scenes"]}
    assert status == {"a": ("done", ""), "b": ("done", ""), "poison": ("failed", "no camera poses")}
    assert (tmp_path / "out/batch_logs/poison.1.log").read_text() == "razer: no"


def test_memory_that_ran_out_is_doubled_and_a_node_that_failed_is_avoided(tmp_path):
    folder = recordings(tmp_path / "scans", a=9)

    def answer(task: SceneTask) -> Outcome:
        if task.number == 1:
            return ended(task, "killed", "memory", node_id="n1")
        return ended(task, "lost", "elsewhere", node_id="n2") if task.number == 2 else made(task)

    (first, second, third), report, _ = run(folder, tmp_path / "out", answer)
    assert second.needs.memory_mb == pytest.approx(2 * first.needs.memory_mb, abs=256)
    assert third.needs.memory_mb == second.needs.memory_mb
    assert (first.avoid, second.avoid, third.avoid) == ("", "n1", "n2")
    assert report.scenes["a"].attempts == 3
    assert [entry["reason"] for entry in report.scenes["a"].history] == ["killed", "lost", ""]


def test_attempts_are_bounded_and_memory_by_what_there_is(tmp_path):
    folder = recordings(tmp_path / "scans", a=9)
    tasks, report, _ = run(folder, tmp_path / "out", lambda task: ended(task, "killed", "memory"), stride=1)
    assert [task.number for task in tasks] == [1, 2, 3]
    assert report.scenes["a"].status == "failed"
    fits = Estimator(0.02, 2, 0).needs(RecordingSize(9, 0), n_short_of_memory=9).within(Needs(1, 5000.0))
    assert fits == Needs(1, 5000.0)


def test_a_batch_that_is_ended_goes_on_with_what_is_not_done(tmp_path):
    folder = recordings(tmp_path / "scans", a=9, b=8, c=7)

    def until_b(task: SceneTask) -> Outcome:
        if task.name == "b":
            raise KeyboardInterrupt
        return made(task)

    with pytest.raises(KeyboardInterrupt):
        run(folder, tmp_path / "out", until_b)
    written = json.loads((tmp_path / "out/report.json").read_text())
    assert [entry["status"] for entry in written["scenes"]] == ["done", "unfinished", "unfinished"]
    with pytest.raises(BadInput, match="--resume"):
        run(folder, tmp_path / "out", made)
    with pytest.raises(BadInput, match="other options"):
        run(folder, tmp_path / "out", made, resume=True, stride=3)
    tasks, report, written = run(folder, tmp_path / "out", made, resume=True)
    assert [task.name for task in tasks] == ["b", "c"]
    assert written["totals"]["done"] == 3
    assert report.scenes["a"].attempts == 1


def test_a_run_folder_that_does_not_arrive_is_no_result(tmp_path):
    folder = recordings(tmp_path / "scans", a=9)
    _, report, _ = run(folder, tmp_path / "out", lambda task: ended(task, node="far"))
    assert report.scenes["a"].status == "failed"
    assert "far wrote it where" in report.scenes["a"].reason


def test_what_an_evaluation_remarks_is_told_with_its_scene(tmp_path, capsys):
    folder = recordings(tmp_path / "scans", a=9)
    run(folder, tmp_path / "out", lambda task: replace(made(task), result=b"", notes=("note: a name is unknown",)))
    assert capsys.readouterr().err == "note: a: a name is unknown\n"


def test_needs_are_learnt_from_finished_scenes():
    estimator, size = Estimator(0.02, 4.0, 0.0), RecordingSize(100, 0)
    before = estimator.needs(size), estimator.seconds(size)
    for _ in range(3):
        estimator.learn(size, Outcome("a", seconds=3 * before[1], cpu_s=1.3 * 3 * before[1], peak_mb=9000.0))
    after = estimator.needs(size)
    assert 9000 * 1.2 <= after.memory_mb <= 9000 * 1.2 + 256
    assert after.cpus == 1.5
    assert estimator.seconds(size) == pytest.approx(3 * before[1])
    assert estimator.seconds(RecordingSize(200, 0)) > estimator.seconds(size)


def test_frames_are_those_that_will_be_mapped():
    own = {f"{kind}/{i:06d}.png": 10 for kind in ("color", "depth") for i in range(40)} | {"trajectory.txt": 1}
    seven = {f"frame-{i:06d}.{kind}": 10 for i in range(30) for kind in ("color.png", "depth.png", "pose.txt")}
    everything = BatchPlan.of(RunOptions(), None).settings
    some = BatchPlan.of(RunOptions(start=4, stride=3, max_frames=5), None).settings
    assert RecordingSize.of(own, everything) == RecordingSize(40, 801)
    assert RecordingSize.of(seven, everything).n_frames == 30
    assert RecordingSize.of({"": 40_000_000}, everything).n_frames == 100
    assert RecordingSize.of(own, some).n_frames == 5
    assert RecordingSize.of({}, everything).n_frames == 1


def test_options_are_handed_on_as_they_were_given(tmp_path):
    options = RunOptions(max_frames=7, timeline=False, sparse=True, set=("a.b=1", "c.d=x y"), trust_plugins=True)
    assert set(run_words(options)) == {
        "--max-frames=7",
        "--no-timeline",
        "--sparse",
        "--set=a.b=1",
        "--set=c.d=x y",
        "--trust-plugins",
    }
    (tmp_path / "settings.toml").write_text("[voxels]\nvoxel_size_m = 0.04\n")
    plan = BatchPlan.of(RunOptions(config=tmp_path / "settings.toml", device="cuda"), None, cores=2)
    assert plan.words == ("--device=cuda",)
    assert plan.config == "[voxels]\nvoxel_size_m = 0.04\n"
    assert replace(plan.template.needs, memory_mb=0) == Needs(2.0, 0.0, 1.0)
    assert plan.settings.voxels.voxel_size_m == 0.04


@pytest.mark.parametrize("options", [{"poses": "both"}, {"poses_from": Path("x")}, {"poses": Path("x")}])
def test_options_of_one_recording_are_refused(options):
    with pytest.raises(BadInput, match="poses"):
        BatchPlan.of(RunOptions(**options), None)


def test_a_damaged_report_is_refused(tmp_path):
    folder, out = recordings(tmp_path / "scans", a=9), tmp_path / "out"
    run(folder, out, made)
    written = json.loads((out / "report.json").read_text())
    for damage in ({"surprise": 1}, {"attempts": "many"}, {"history": None}):
        entry = written["scenes"][0] | damage
        (out / "report.json").write_text(json.dumps(written | {"scenes": [entry]}))
        with pytest.raises(BadInput, match="damaged"):
            begun_report(Place(str(out)), written["settings"], {"a": True}, resume=True)


def test_what_is_in_the_way_of_a_map_or_of_no_batch_is_said_before_any_work(tmp_path):
    folder = recordings(tmp_path / "scans", a=9, b=8)
    scenes, plan = scenes_of(str(folder)), BatchPlan.of(RunOptions(), None)

    def refused(out: Path) -> str:
        with pytest.raises(BadInput) as caught:
            begin(scenes, Place(str(out)), plan, pytest.fail, PlainConsole(quiet=True), resume=False)
        return str(caught.value)

    assert "scans/a is in the way" in refused(folder)
    made(replace(plan.template, name="b", out=str(tmp_path / "out/b")))
    assert "out/b is there, and of no batch" in refused(tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["b"]


def test_a_map_that_is_there_is_done_whatever_the_report_says(tmp_path):
    """As where the batch was killed between the two."""
    folder, out = recordings(tmp_path / "scans", a=9), tmp_path / "out"
    run(folder, out, made)
    written = json.loads((out / "report.json").read_text())
    entry = written["scenes"][0] | {"status": "unfinished", "reason": "the batch was ended before"}
    (out / "report.json").write_text(json.dumps(written | {"scenes": [entry]}))
    tasks, _, written = run(folder, out, made, resume=True)
    assert tasks == []
    assert (written["scenes"][0]["status"], written["scenes"][0]["reason"]) == ("done", "")


def test_a_report_has_a_scene_once():
    report = BatchReport(Place("/nowhere"), {}, {})
    assert report.as_json()["totals"]["scenes"] == 0
