"""The embedder clip by open_clip, with a tiny model written as the library writes its own."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

from razer.errors import BadInput
from razer.models.clip.embedder import ClipEmbedder

torch = pytest.importorskip("torch")
open_clip = pytest.importorskip("open_clip")
from razer.models.clip.open_clip_training import model_arguments  # noqa: E402

MODEL = {
    "embed_dim": 24,
    "vision_cfg": {"image_size": 32, "layers": 2, "width": 64, "head_width": 16, "patch_size": 8},
    "text_cfg": {"context_length": 16, "vocab_size": 49408, "width": 32, "heads": 2, "layers": 2},
}
COLOURS = {"mean": [0.5, 0.4, 0.3], "std": [0.25, 0.3, 0.2]}
TEXTS = ["a red chair", "Table"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("open_clip")
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": MODEL, "preprocess_cfg": COLOURS}))
    torch.manual_seed(0)
    torch.save(open_clip.create_model(f"local-dir:{folder}").state_dict(), folder / "open_clip_pytorch_model.bin")
    return folder


def test_vectors_are_the_library_s(folder):
    from PIL import Image

    model, _, prepared = open_clip.create_model_and_transforms(f"local-dir:{folder}")
    rgb = np.random.default_rng(0).integers(0, 256, (32, 32, 3), dtype=np.uint8)
    with torch.inference_mode():
        picture = model.eval().encode_image(prepared(Image.fromarray(rgb))[None], normalize=True)[0].numpy()
        texts = model.encode_text(open_clip.get_tokenizer(f"local-dir:{folder}")(TEXTS), normalize=True).numpy()
    embedder = pickle.loads(pickle.dumps(ClipEmbedder(folder, crop_scale=1)))
    np.testing.assert_allclose(embedder.embed_region(rgb, np.ones((32, 32), bool)), picture, atol=1e-5)
    np.testing.assert_allclose(embedder.embed_texts(TEXTS), texts, atol=1e-5)


def test_a_file_of_weights_with_the_name_of_its_architecture(folder, tmp_path):
    open_clip.add_model_config(_config_file(tmp_path))
    weights = folder / "open_clip_pytorch_model.bin"
    named = ClipEmbedder(weights, architecture="razer-tiny")
    np.testing.assert_allclose(named.embed_texts(TEXTS), ClipEmbedder(folder).embed_texts(TEXTS), atol=1e-6)


def _config_file(folder):
    file = folder / "razer-tiny.json"
    file.write_text(json.dumps(MODEL))
    return file


@pytest.mark.parametrize(
    ("architecture", "mean", "quick_gelu"),
    [
        ("MobileCLIP2-S0", (0.0, 0.0, 0.0), False),
        ("PE-Core-B-16", (0.5, 0.5, 0.5), False),
        ("ViT-L-14:laion2b_s32b_b82k", (0.5, 0.5, 0.5), False),
        ("ViT-B-32:openai", open_clip.OPENAI_DATASET_MEAN, True),
        ("ViT-B-32:laion2b_s34b_b79k", open_clip.OPENAI_DATASET_MEAN, False),
    ],
)
def test_weights_alone_get_the_colours_and_activations_they_were_trained_with(architecture, mean, quick_gelu):
    choices = model_arguments(architecture)
    assert choices["force_preprocess_cfg"]["mean"] == mean
    assert choices["force_quick_gelu"] is quick_gelu


def test_colours_of_weights_alone_reach_the_pictures(tmp_path):
    """The smallest architecture whose published weights want other colours than the library's default."""
    model = open_clip.create_model("PE-Core-T-16-384", pretrained_image=False)
    torch.save(model.state_dict(), tmp_path / "weights.pt")
    wanted = ClipEmbedder(tmp_path / "weights.pt", architecture="PE-Core-T-16-384")._towers.image_input
    assert (wanted.size, wanted.mean, wanted.std) == (384, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("architecture", "message"),
    [
        ("ViT-B-32", "set embedder option architecture to ViT-B-32:TAG, with one of openai,"),
        ("ViT-B-32:nobody", "open_clip knows no weights 'nobody' of ViT-B-32"),
        ("MobileCLIP2-S9", "open_clip knows no architecture 'MobileCLIP2-S9': it has MobileCLIP2-S"),
    ],
)
def test_an_architecture_that_does_not_say_enough(architecture, message):
    with pytest.raises(BadInput, match=message):
        model_arguments(architecture)


def test_features_at_each_pixel_are_refused(folder):
    embedder = ClipEmbedder(folder, vectors="dense")
    with pytest.raises(BadInput, match="need a model of transformers; set vectors to crops"):
        embedder.embed_region(np.zeros((32, 32, 3), np.uint8), np.ones((32, 32), bool))


def test_damage_is_one_line(folder, tmp_path):
    (tmp_path / "open_clip_config.json").write_text((folder / "open_clip_config.json").read_text())
    with pytest.raises(BadInput, match="cannot be loaded by open_clip") as missing:
        ClipEmbedder(tmp_path).embed_texts(TEXTS)
    whole = (folder / "open_clip_pytorch_model.bin").read_bytes()
    (tmp_path / "open_clip_pytorch_model.bin").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInput, match="cannot be loaded by open_clip") as truncated:
        ClipEmbedder(tmp_path).embed_texts(TEXTS)
    for caught in (missing, truncated):
        assert "\n" not in str(caught.value)
