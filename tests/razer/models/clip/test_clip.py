"""The embedder clip with tiny checkpoints of transformers, against the library's own way of using them."""

from __future__ import annotations

import pickle
from itertools import combinations

import numpy as np
import pytest

from razer.errors import BadInput
from razer.frame import Masks
from razer.models import ImageEncoder, TextEncoder, make_embedder
from razer.models.clip.embedder import ClipEmbedder
from tests.support import clip_checkpoints as tiny

torch, transformers = tiny.torch, tiny.transformers
TEXTS = ["a red chair", "table", "a photo of the table ."]
MAKERS = {"clip": tiny.clip_folder, "siglip": tiny.siglip_folder, "siglip2": tiny.flexible_siglip_folder}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    return {name: make(tmp_path_factory.mktemp(name)) for name, make in MAKERS.items()}


@pytest.fixture(params=MAKERS)
def folder(request, folders):
    return folders[request.param]


@pytest.fixture(scope="module")
def frame():
    return tiny.colourful_frame()


@pytest.fixture(scope="module")
def masks():
    return tiny.overlapping_masks()


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def batch_of(pictures):
    """Pictures (N, 32, 32, 3) uint8 as the library's own image processor makes them for a model of fixed size."""
    from transformers.models.clip.image_processing_pil_clip import CLIPImageProcessorPil

    processor = CLIPImageProcessorPil(
        image_mean=tiny.MEAN, image_std=tiny.STD, do_resize=False, do_center_crop=False, do_convert_rgb=False
    )
    return processor(list(pictures), return_tensors="pt")["pixel_values"]


def test_it_has_both_sides_and_unit_vectors(folder, frame, masks):
    embedder = make_embedder("clip", {"weights": str(folder)})
    assert isinstance(embedder, TextEncoder)
    assert isinstance(embedder, ImageEncoder)
    vectors, texts = embedder.embed(frame, masks), embedder.embed_texts(TEXTS)
    assert vectors.shape == (5, texts.shape[1])
    assert vectors.dtype == texts.dtype == np.float32
    for rows in (vectors, texts):
        np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-5)
        apart = [np.abs(a - b).max() for a, b in combinations(rows, 2)]
        assert min(apart) > 3e-3, "far more than the tolerance of the tests below"


@pytest.mark.parametrize("name", ["clip", "siglip"])
def test_image_vectors_are_the_library_s(folders, frame, name):
    square = np.zeros((48, 64), bool)
    square[3:35, 9:41] = True
    embedder = ClipEmbedder(folders[name], crop_scale=1, background=1)
    model = transformers.AutoModel.from_pretrained(folders[name]).eval()
    with torch.inference_mode():
        expected = model.get_image_features(batch_of([frame.rgb[3:35, 9:41]])).pooler_output[0].numpy()
    np.testing.assert_allclose(embedder.embed_region(frame.rgb, square), unit(expected), atol=1e-5)


def test_image_vectors_of_flexible_siglip_are_the_library_s(folders, frame):
    from transformers.models.siglip2.image_processing_pil_siglip2 import Siglip2ImageProcessorPil

    processor = Siglip2ImageProcessorPil(
        image_mean=tiny.MEAN, image_std=tiny.STD, patch_size=tiny.PATCH, max_num_patches=16
    )
    picture = frame.rgb[3:35, 9:41]
    model = transformers.AutoModel.from_pretrained(folders["siglip2"]).eval()
    with torch.inference_mode():
        expected = model.get_image_features(**processor([picture], return_tensors="pt")).pooler_output[0].numpy()
    embedder = ClipEmbedder(folders["siglip2"], crop_scale=1, background=1)
    np.testing.assert_allclose(embedder.embed_region(picture, np.ones((32, 32), bool)), unit(expected), atol=1e-5)


def test_text_vectors_are_the_library_s(folder):
    model = transformers.AutoModel.from_pretrained(folder).eval()
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    # As the library's examples do it: to the longest for CLIP, to full length for SigLIP, whose processor has no mask.
    if model.config.model_type == "clip":
        given = tokenizer(TEXTS, padding=True, truncation=True, max_length=tiny.LENGTH, return_tensors="pt")
    else:
        given = tokenizer(TEXTS, padding="max_length", max_length=tiny.LENGTH, return_tensors="pt")
        given = {"input_ids": given["input_ids"]}
    with torch.inference_mode():
        expected = model.get_text_features(**given).pooler_output.numpy()
    embedder = ClipEmbedder(folder)
    np.testing.assert_allclose(embedder.embed_texts(TEXTS), unit(expected), atol=1e-5)
    np.testing.assert_allclose(embedder.embed_texts(["A Red CHAIR"]), unit(expected[:1]), atol=1e-5)


def test_texts_longer_than_the_model_reads_are_cut(folder):
    long = " ".join(["chair"] * 40)
    np.testing.assert_allclose(np.linalg.norm(ClipEmbedder(folder).embed_texts([long])), 1, atol=1e-5)


@pytest.mark.parametrize("vectors", ["crops", "dense", "tokens"])
def test_batches_and_company_do_not_change_a_vector(folder, frame, masks, vectors):
    together = ClipEmbedder(folder, vectors=vectors).embed(frame, masks)
    in_twos = ClipEmbedder(folder, vectors=vectors, batch=2)
    np.testing.assert_allclose(in_twos.embed(frame, masks), together, atol=1e-5)
    alone = np.stack([in_twos.embed_region(frame.rgb, mask) for mask in masks.masks])
    np.testing.assert_allclose(alone, together, atol=1e-5)


def test_texts_in_batches(folder):
    np.testing.assert_allclose(
        ClipEmbedder(folder, batch=2).embed_texts(TEXTS), ClipEmbedder(folder).embed_texts(TEXTS), atol=1e-5
    )


def test_crops_without_background_ignore_what_is_outside(folder, frame, masks):
    outside = np.where(masks.masks[0, :, :, None], frame.rgb, 255 - frame.rgb)
    strict, loose = ClipEmbedder(folder, background=0), ClipEmbedder(folder, background=0.5)
    vectors = [[e.embed_region(rgb, masks.masks[0]) for rgb in (frame.rgb, outside)] for e in (strict, loose)]
    np.testing.assert_array_equal(*vectors[0])
    assert np.abs(np.subtract(*vectors[1])).max() > 1e-3


def test_value_path_is_a_last_block_where_patches_attend_to_themselves_only(folders, frame):
    model = transformers.AutoModel.from_pretrained(folders["clip"], attn_implementation="eager").eval()
    vision, last = model.vision_model, model.vision_model.encoder.layers[-1]
    entered = {}
    last.register_forward_hook(
        lambda _, given, keywords, __: entered.update(x=(*given, *keywords.values())[0]), with_kwargs=True
    )
    picture = frame.rgb[:32, :32]
    with torch.inference_mode():
        vision(batch_of([picture]))
        alone = torch.full((17, 17), -torch.inf).fill_diagonal_(0)[None, None]
        values, _ = last.self_attn(last.layer_norm1(entered["x"]), attention_mask=alone)
        expected = model.visual_projection(vision.post_layernorm(values))[0, 1:].numpy()
    embedder = ClipEmbedder(folders["clip"], vectors="dense", map_scale=1)
    cells = np.arange(1024).reshape(32, 32) // 256 * 4 + np.arange(32) // 8
    vectors = np.stack([embedder.embed_region(picture, cells == cell) for cell in range(16)])
    np.testing.assert_allclose(vectors, unit(expected), atol=1e-4)


@pytest.mark.parametrize("name", ["siglip", "siglip2"])
def test_dense_siglip_pools_each_patch_alone(folders, frame, name):
    embedder = ClipEmbedder(folders[name], vectors="dense", map_scale=1)
    picture = frame.rgb[:32, :32]
    image = embedder._towers.image_input.batch(picture[None])[0]
    tokens = embedder._towers.feature_map(image, aligned=False)
    aligned = embedder._towers.feature_map(image, aligned=True)
    head = transformers.AutoModel.from_pretrained(folders[name]).eval().vision_model.head
    with torch.inference_mode():
        one = head(torch.from_numpy(tokens[2, 3]).reshape(1, 1, -1))[0].numpy()
    np.testing.assert_allclose(aligned[2, 3], one, atol=1e-4)


def test_a_patch_s_features_lie_where_the_patch_is(folder):
    """48x64 pixels at 1.5 pictures of 32 for the shorter side are 6x8 patches of 8."""
    towers = ClipEmbedder(folder, vectors="dense")._towers
    layers = towers._model.vision_model.encoder.layers
    for layer in layers if hasattr(towers._model.vision_model, "head") else layers[:-1]:
        for parameter in layer.self_attn.out_proj.parameters():
            parameter.data.zero_()  # now no patch hears of another before the last step
    blank = np.zeros((3, 48, 64), np.float32)
    changed = blank.copy()
    changed[:, 16:24, 40:48] = 1
    difference = np.abs(towers.feature_map(changed, aligned=True) - towers.feature_map(blank, aligned=True)).max(axis=2)
    assert difference.shape == (6, 8)
    assert difference[2, 5] > 1e-2
    assert (difference > 1e-5).sum() == 1


def test_own_tokens_know_no_words(folder, frame, masks):
    embedder = ClipEmbedder(folder, vectors="tokens")
    np.testing.assert_allclose(np.linalg.norm(embedder.embed(frame, masks), axis=1), 1, atol=1e-5)
    with pytest.raises(BadInput, match="set embedder option vectors to crops or dense"):
        embedder.embed_texts(["a chair"])


def test_it_travels_before_and_after_use(folder, frame, masks):
    embedder = ClipEmbedder(folder)
    unused = pickle.loads(pickle.dumps(embedder))
    expected = embedder.embed(frame, masks)
    sent = pickle.dumps(embedder)
    assert len(sent) < 2000, "the model itself stays behind"
    for received in (unused, pickle.loads(sent)):
        np.testing.assert_array_equal(received.embed(frame, masks), expected)


def test_no_masks_need_no_model(folder, frame, monkeypatch):
    monkeypatch.setattr("razer.models.clip.embedder.open_towers", None)
    assert len(ClipEmbedder(folder).embed(frame, Masks.none(48, 64))) == 0
