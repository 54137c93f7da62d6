"""Real CLIP vectors through the whole method: a simulated apartment is mapped and asked by words."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.config import MapperConfig, VoxelSettings
from razer.errors import BadInput, UnusableFrame
from razer.mapper import Mapper
from razer.models import make_segmenter
from razer.models.appearance import AppearanceEmbedder
from razer.panoptic_map import PanopticMap
from razer.query.kinds import expand
from razer.semantics.labelling import known_categories, label
from razer.vocabulary import vocabulary
from tests.support.named_vectors import NamedVectors

N_FRAMES = 200  # of fewer, a third of the objects are seen too seldom to tell through the noise


@pytest.fixture(scope="module")
def apartment(real_data):
    """(the map at the end, what was found by name halfway, the embedder)."""
    embedder = NamedVectors(str(real_data / "clip-vit-b32" / "lvis.npz"))
    config = MapperConfig(voxels=VoxelSettings(voxel_size_m=0.06))
    mapper = Mapper(config, make_segmenter("oracle", {}), embedder)
    scene = SyntheticScene("apartment", 0, N_FRAMES, 160, 120)
    halfway = None
    for index in range(N_FRAMES):
        try:
            mapper.step(scene[index])
        except UnusableFrame:
            continue
        if index == N_FRAMES // 2:
            running = mapper.snapshot()
            names = {o.class_name for o in running.objects} & set(embedder.row)
            halfway = {name: running.query(name) for name in sorted(names)}
    mapper.finish()
    return mapper.snapshot(), halfway, embedder


def is_first(answer, name):
    return answer.found and answer.hits[0].object.class_name == name


@pytest.mark.full
def test_a_running_map_answers_between_frames(apartment):
    _, halfway, _ = apartment
    assert len(halfway) >= 8
    assert sum(is_first(answer, name) for name, answer in halfway.items()) >= 0.5 * len(halfway)


def test_things_are_found_by_name_and_what_is_not_there_is_not(apartment):
    panoptic, _, embedder = apartment
    present = sorted({o.class_name for o in panoptic.objects} & set(embedder.row))
    rows = {embedder.row[name] for name in present}
    absent = [name for row, name in enumerate(embedder.known_names) if row not in rows]
    absent = [absent[i] for i in np.random.default_rng(0).permutation(len(absent))[:100]]
    assert len(present) >= 20
    found = [name for name in present if panoptic.query(name).found]
    right = [name for name in present if is_first(panoptic.query(name), name)]
    wrong = [name for name in absent if panoptic.query(name).found]
    assert len(found) >= 0.6 * len(present)
    assert len(right) >= 0.55 * len(present)
    assert len(wrong) <= 0.2 * len(absent)


def test_kinds_find_what_belongs_to_them_and_little_else(apartment):
    panoptic, _, embedder = apartment
    right = wrong = missed = 0
    for kind in ("furniture", "something to sit on", "electronics", "storage furniture", "dishes", "light", "cookware"):
        answer = panoptic.query(kind)
        rows = {embedder.row[embedder.known_names[row]] for row in expand(kind, embedder.known_names).rows}
        meant = {o.id for o in panoptic.objects if embedder.row.get(o.class_name) in rows}
        found = {hit.object.id for hit in answer.hits}
        right, wrong, missed = right + len(found & meant), wrong + len(found - meant), missed + len(meant - found)
    assert right >= 20
    assert wrong <= 0.15 * (right + wrong)
    assert missed <= 0.55 * (right + missed)


def test_hits_are_ranked_above_the_threshold(apartment):
    panoptic, _, _ = apartment
    answer = panoptic.query("bed", threshold=0.0)
    scores = [hit.score for hit in answer.hits]
    assert len(scores) == len(panoptic.embedding_table)
    assert scores == sorted(scores, reverse=True)
    assert panoptic.query("bed", threshold=0.5).hits == tuple(h for h in answer.hits if h.score >= 0.5)


def test_classes_of_a_vocabulary(apartment):
    panoptic, _, embedder = apartment
    known = known_categories(panoptic, vocabulary("scannet200"))
    given = {found.id: found.category.name for found in label(panoptic, known)}
    names = {category.name for category in known}
    asked = [o for o in panoptic.objects if o.class_name in names and o.observations >= 5]
    right = [o for o in asked if embedder.row[given[o.id]] == embedder.row[o.class_name]]
    assert len(asked) >= 15
    assert len(right) >= 0.6 * len(asked)


def test_a_map_without_words_says_so(apartment):
    panoptic, _, _ = apartment
    with pytest.raises(BadInput, match="no embedder is known"):
        PanopticMap(panoptic.objects, panoptic.mesh).query("bed")
    nameless = Mapper(MapperConfig(), make_segmenter("geometric", {}), AppearanceEmbedder()).snapshot()
    with pytest.raises(BadInput, match="no text encoder"):
        nameless.query("bed")
