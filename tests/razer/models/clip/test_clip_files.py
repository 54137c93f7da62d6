"""What the embedder clip says about models that are missing, of another kind, or damaged."""

from __future__ import annotations

import io
import json
import shutil
from contextlib import suppress

import numpy as np
import pytest

from razer.errors import BadInput
from razer.models import make_embedder
from razer.models.clip.embedder import ClipEmbedder
from tests.support import clip_checkpoints as tiny

transformers = tiny.transformers


@pytest.fixture(scope="module")
def intact(tmp_path_factory):
    return tiny.clip_folder(tmp_path_factory.mktemp("clip"))


@pytest.fixture
def folder(intact, tmp_path):
    return shutil.copytree(intact, tmp_path / "clip")


def used(folder):
    """Both sides asked."""
    embedder = ClipEmbedder(folder)
    embedder.embed_region(np.zeros((8, 8, 3), np.uint8), np.ones((8, 8), bool))
    embedder.embed_texts(["a chair"])


def one_weight_less(folder):
    from safetensors.numpy import load_file, save_file

    tensors = load_file(folder / "model.safetensors")
    del tensors["visual_projection.weight"]
    save_file(tensors, folder / "model.safetensors", {"format": "pt"})


def half_of(file):
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def of_another_size(folder):
    config = json.loads((folder / "config.json").read_text())
    config["projection_dim"] += 1
    (folder / "config.json").write_text(json.dumps(config))


AT_ONCE = [
    (lambda f: shutil.rmtree(f), "no model file"),
    (lambda f: (f / "config.json").unlink(), "is no image-text model: it needs"),
    (lambda f: (f / "model.safetensors").unlink(), "but has no weights"),
    (lambda f: (f / "config.json").write_text('{"model_type": "bert"}'), "is no image-text model but a bert"),
    (lambda f: (f / "config.json").write_text("nonsense"), r"config\.json cannot be read"),
]
ON_USE = [
    (lambda f: half_of(f / "model.safetensors"), "cannot be loaded as an image-text model"),
    (one_weight_less, r"lacks weights of the model, among them visual_projection\.weight"),
    (of_another_size, r"not of the size that config\.json says, text_projection\.weight"),
    (lambda f: half_of(f / "tokenizer.json"), "the tokenizer of .* cannot be loaded"),
    (lambda f: (f / "preprocessor_config.json").unlink(), r"no preprocessor_config\.json beside it"),
]


@pytest.mark.parametrize(("spoil", "message"), AT_ONCE)
def test_what_can_be_seen_without_loading_is_said_at_once(folder, spoil, message):
    spoil(folder)
    with pytest.raises(BadInput, match=message) as caught:
        ClipEmbedder(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("spoil", "message"), ON_USE)
def test_damage_is_one_line(folder, spoil, message):
    used(folder)
    spoil(folder)
    with pytest.raises(BadInput, match=message) as caught:
        used(folder)
    assert "\n" not in str(caught.value)


def test_an_image_encoder_alone_is_refused(tmp_path):
    config = transformers.CLIPVisionConfig(
        hidden_size=32, intermediate_size=32, num_hidden_layers=1, num_attention_heads=2, image_size=32, patch_size=8
    )
    transformers.CLIPVisionModel(config).save_pretrained(tmp_path)
    with pytest.raises(BadInput, match="is no image-text model but a clip_vision_model"):
        ClipEmbedder(tmp_path)


def test_a_model_that_names_both_but_brings_none_together(folder):
    config = json.loads((folder / "config.json").read_text())
    (folder / "config.json").write_text(json.dumps({**config, "model_type": "vision-text-dual"}))
    with pytest.raises(BadInput, match="cannot be loaded as an image-text model"):
        used(folder)


@pytest.mark.parametrize("library", ["transformers", "open_clip"])
def test_a_missing_library_is_named_with_its_command(folder, monkeypatch, library):
    if library == "open_clip":
        (folder / "config.json").unlink()
        (folder / "open_clip_config.json").write_text("{}")
    monkeypatch.setattr("razer.models.clip.library.find_spec", lambda name: None)
    with pytest.raises(BadInput, match=rf"needs the package {library}: pip install 'razer\["):
        ClipEmbedder(folder)


def test_weights_alone_need_an_architecture(tmp_path):
    (tmp_path / "mobileclip_s0.pt").write_bytes(b"")
    with pytest.raises(BadInput, match="set embedder option architecture"):
        ClipEmbedder(tmp_path / "mobileclip_s0.pt")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "set embedder option weights"),
        ({"weights": "nobody/has-this"}, "hf download nobody/has-this"),
        ({"weights": "...", "vectors": "pixels"}, "vectors is crops, dense or tokens"),
        ({"weights": "...", "crop_scale": 0.1}, "crop_scale 0.1"),
        ({"weights": "...", "background": 1.5}, "background 1.5"),
        ({"weights": "...", "map_scale": 0}, "map_scale 0"),
        ({"weights": "...", "batch": 0}, "batch 0"),
        ({"weights": "...", "unrelated_cosine": 1}, "unrelated_cosine 1"),
        ({"weights": "...", "device": "tpu"}, "device is auto, cpu or cuda"),
        ({"weights": "...", "colour": 1}, "does not take these options"),
    ],
)
def test_options_are_checked(options, message):
    with pytest.raises(BadInput, match=message):
        make_embedder("clip", options)


@pytest.mark.skipif(tiny.torch.cuda.is_available(), reason="there is a CUDA device")
def test_a_device_that_is_not_there(intact):
    with pytest.raises(BadInput, match="no CUDA device"):
        ClipEmbedder(intact, device="cuda").embed_texts(["a chair"])


EVIL = "open({mark!r}, 'w')\nraise SystemExit\n"


@pytest.mark.parametrize(
    ("file", "entries"),
    [
        ("config.json", {"auto_map": {"AutoConfig": "evil.Config", "AutoModel": "evil.Model"}, "model_type": "evil"}),
        ("tokenizer_config.json", {"auto_map": {"AutoTokenizer": ["evil.T", "evil.T"]}, "tokenizer_class": "EvilT"}),
    ],
)
def test_code_that_a_checkpoint_brings_along_is_not_run_even_if_someone_agrees(
    folder, tmp_path, monkeypatch, file, entries
):
    mark = tmp_path / "mark"
    (folder / "evil.py").write_text(EVIL.format(mark=str(mark)))
    content = json.loads((folder / file).read_text()) if (folder / file).exists() else {}
    (folder / file).write_text(json.dumps(content | entries | {"trust_remote_code": True}))
    monkeypatch.setattr("builtins.input", lambda *_: "y")
    monkeypatch.setattr("sys.stdin", io.StringIO("y\n" * 9))
    with suppress(BadInput):  # a tokenizer of another name may still be read as the one that it is
        used(folder)
    assert not mark.exists()
