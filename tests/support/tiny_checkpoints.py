"""Checkpoints of a few kilobytes with random weights, written by the libraries' own save_pretrained."""

from __future__ import annotations

import json
from pathlib import Path

import torch
import transformers as t

LABELS = {0: "wall", 1: "chair", 2: "cup"}


def sam(folder: Path) -> t.SamModel:
    """SAM at 64 pixels."""
    vision = t.SamVisionConfig(
        hidden_size=16, output_channels=16, num_hidden_layers=1, num_attention_heads=2, image_size=64, patch_size=8,
        mlp_dim=16, window_size=2, global_attn_indexes=[0], num_pos_feats=8,
    )  # fmt: skip
    prompt = t.SamPromptEncoderConfig(hidden_size=16, image_size=64, patch_size=8, mask_input_channels=4)
    decoder = t.SamMaskDecoderConfig(
        hidden_size=16, mlp_dim=16, num_hidden_layers=1, num_attention_heads=2, iou_head_hidden_dim=16
    )
    config = t.SamConfig(vision_config=vision, prompt_encoder_config=prompt, mask_decoder_config=decoder)
    model = _saved(t.SamModel, config, folder)
    t.SamImageProcessor(
        size={"longest_edge": 64}, pad_size={"height": 64, "width": 64}, mask_size={"longest_edge": 16},
        mask_pad_size={"height": 16, "width": 16},
    ).save_pretrained(folder)  # fmt: skip
    return model


def sam2(folder: Path) -> t.Sam2Model:
    """SAM 2 at 64 pixels."""
    hiera = t.Sam2HieraDetConfig(
        hidden_size=8, num_attention_heads=1, image_size=[64, 64], patch_kernel_size=[7, 7], patch_stride=[4, 4],
        patch_padding=[3, 3], query_stride=[2, 2], window_positional_embedding_background_size=[4, 4],
        num_query_pool_stages=3, blocks_per_stage=[1, 1, 2, 1], embed_dim_per_stage=[8, 16, 32, 64],
        num_attention_heads_per_stage=[1, 2, 2, 4], window_size_per_stage=[8, 4, 4, 4], global_attention_blocks=[3],
    )  # fmt: skip
    vision = t.Sam2VisionConfig(
        backbone_config=hiera, backbone_channel_list=[64, 32, 16, 8], fpn_hidden_size=32,
        backbone_feature_sizes=[[16, 16], [8, 8], [4, 4]],
    )  # fmt: skip
    prompt = t.Sam2PromptEncoderConfig(hidden_size=32, image_size=64, patch_size=16, mask_input_channels=4)
    decoder = t.Sam2MaskDecoderConfig(
        hidden_size=32, mlp_dim=16, num_hidden_layers=1, num_attention_heads=2, iou_head_hidden_dim=16
    )
    config = t.Sam2Config(vision_config=vision, prompt_encoder_config=prompt, mask_decoder_config=decoder)
    model = _saved(t.Sam2Model, config, folder)
    settings = {"image_mean": [0.5, 0.5, 0.5], "image_std": [0.25, 0.25, 0.25], "size": {"height": 64, "width": 64}}
    (folder / "processor_config.json").write_text(json.dumps({"image_processor": settings}))
    return model


def sam3(folder: Path) -> t.Sam3Model:
    """SAM 3 at 56 pixels."""
    vit = t.Sam3ViTConfig(
        hidden_size=16, intermediate_size=16, num_hidden_layers=2, num_attention_heads=2, image_size=56, patch_size=14,
        window_size=2, global_attn_indexes=[1], pretrain_image_size=56,
    )  # fmt: skip
    vision = t.Sam3VisionConfig(
        backbone_config=vit, fpn_hidden_size=16, backbone_feature_sizes=[[16, 16], [8, 8], [4, 4]]
    )
    small = {"hidden_size": 16, "intermediate_size": 16, "num_attention_heads": 2}
    config = t.Sam3Config(
        vision_config=vision,
        text_config={**small, "num_hidden_layers": 1, "vocab_size": 64, "projection_dim": 16,
                     "max_position_embeddings": 32, "eos_token_id": 54, "bos_token_id": 53},
        geometry_encoder_config={**small, "num_layers": 1},
        detr_encoder_config={**small, "num_layers": 1},
        detr_decoder_config={**small, "num_layers": 1, "num_queries": 6},
        mask_decoder_config={"hidden_size": 16, "num_attention_heads": 2},
    )  # fmt: skip
    model = _saved(t.Sam3Model, config, folder)
    clip_tokenizer().save_pretrained(folder)
    return model


def grounding_dino(folder: Path) -> t.GroundingDinoForObjectDetection:
    """Grounding DINO with a tokenizer of letters and a few words, and room for 12 tokens of text."""
    backbone = t.SwinConfig(
        image_size=32, embed_dim=8, depths=[1, 1, 1, 1], num_heads=[1, 1, 1, 1], window_size=2,
        out_features=["stage2", "stage3", "stage4"],
    )  # fmt: skip
    text = t.BertConfig(
        vocab_size=64, hidden_size=16, num_hidden_layers=1, num_attention_heads=2, intermediate_size=16,
        max_position_embeddings=32,
    )  # fmt: skip
    config = t.GroundingDinoConfig(
        backbone_config=backbone, text_config=text, d_model=32, encoder_layers=1, encoder_ffn_dim=16,
        encoder_attention_heads=2, decoder_layers=2, decoder_ffn_dim=16, decoder_attention_heads=2, num_queries=9,
        num_feature_levels=3, max_text_len=12,
    )  # fmt: skip
    model = _saved(t.GroundingDinoForObjectDetection, config, folder)
    (folder / "vocab.txt").write_text("\n".join(BERT_TOKENS))
    tokenizer = t.BertTokenizer.from_pretrained(folder)
    images = t.GroundingDinoImageProcessor(size={"shortest_edge": 64, "longest_edge": 96})
    t.GroundingDinoProcessor(images, tokenizer).save_pretrained(folder)
    return model


def owlv2(folder: Path) -> t.Owlv2ForObjectDetection:
    """OWLv2 at 32 pixels."""
    small = {"hidden_size": 16, "intermediate_size": 16, "num_hidden_layers": 1, "num_attention_heads": 2}
    config = t.Owlv2Config(
        text_config={**small, "vocab_size": 64, "max_position_embeddings": 16, "eos_token_id": 54, "bos_token_id": 53},
        vision_config={**small, "image_size": 32, "patch_size": 8},
        projection_dim=16,
    )
    model = _saved(t.Owlv2ForObjectDetection, config, folder)
    images = t.Owlv2ImageProcessor(size={"height": 32, "width": 32})
    t.Owlv2Processor(images, clip_tokenizer()).save_pretrained(folder)
    return model


def mask2former(folder: Path) -> t.Mask2FormerForUniversalSegmentation:
    """Mask2Former at 64 pixels, with the classes LABELS."""
    config = t.Mask2FormerConfig(
        backbone_config=_swin(), feature_size=32, mask_feature_size=32, hidden_dim=32, encoder_feedforward_dim=16,
        encoder_layers=1, decoder_layers=2, num_attention_heads=2, dim_feedforward=16, num_queries=7,
        id2label=LABELS,
    )  # fmt: skip
    model = _saved(t.Mask2FormerForUniversalSegmentation, config, folder)
    t.Mask2FormerImageProcessor(size={"height": 64, "width": 64}).save_pretrained(folder)
    return model


def oneformer(folder: Path) -> t.OneFormerForUniversalSegmentation:
    """OneFormer at 64 pixels, with the classes LABELS, and settings that name a file at the hub."""
    config = t.OneFormerConfig(
        backbone_config=_swin(), hidden_dim=32, conv_dim=32, mask_dim=32, num_attention_heads=2, dim_feedforward=16,
        encoder_feedforward_dim=16, encoder_layers=1, decoder_layers=2, num_queries=7, text_encoder_width=16,
        text_encoder_num_layers=1, text_encoder_vocab_size=64, text_encoder_context_length=20, task_seq_len=20,
        id2label=LABELS, is_training=False,
    )  # fmt: skip
    model = _saved(t.OneFormerForUniversalSegmentation, config, folder)
    settings = {
        "image_processor_type": "OneFormerImageProcessor",
        "size": {"height": 64, "width": 64},
        "repo_path": "shi-labs/oneformer_demo",
        "class_info_file": "coco_panoptic.json",
        "num_text": 4,
    }
    (folder / "preprocessor_config.json").write_text(json.dumps(settings))
    clip_tokenizer().save_pretrained(folder)
    return model


def segformer(folder: Path) -> t.SegformerForSemanticSegmentation:
    """SegFormer at 64 pixels, with the classes LABELS."""
    config = t.SegformerConfig(
        num_encoder_blocks=2, depths=[1, 1], sr_ratios=[2, 1], hidden_sizes=[8, 16], patch_sizes=[7, 3],
        strides=[4, 2], num_attention_heads=[1, 2], mlp_ratios=[2, 2], decoder_hidden_size=16, id2label=LABELS,
    )  # fmt: skip
    model = _saved(t.SegformerForSemanticSegmentation, config, folder)
    t.SegformerImageProcessor(size={"height": 64, "width": 64}).save_pretrained(folder)
    return model


def upernet(folder: Path) -> t.UperNetForSemanticSegmentation:
    """UPerNet on ConvNeXt at 64 pixels, with the classes LABELS."""
    backbone = t.ConvNextConfig(
        hidden_sizes=[4, 6, 8, 10], depths=[1, 1, 1, 1], out_features=["stage1", "stage2", "stage3", "stage4"]
    )
    config = t.UperNetConfig(
        backbone_config=backbone, hidden_size=8, use_auxiliary_head=False, pool_scales=[1, 2], id2label=LABELS
    )
    model = _saved(t.UperNetForSemanticSegmentation, config, folder)
    t.SegformerImageProcessor(size={"height": 64, "width": 64}).save_pretrained(folder)
    return model


def clip_tokenizer() -> t.CLIPTokenizer:
    """One token for each letter."""
    letters = "abcdefghijklmnopqrstuvwxyz"
    tokens = ["<pad>", *letters, *(f"{letter}</w>" for letter in letters), "<|startoftext|>", "<|endoftext|>"]
    return t.CLIPTokenizer(vocab={token: number for number, token in enumerate(tokens)}, merges=[])


BERT_TOKENS = [
    "[PAD]", "[UNK]", "[CLS]", "[SEP]", "[MASK]", ".", "cup", "red", "chair", "table", "##s",
    *(f"[unused{i}]" for i in range(53)),
]  # fmt: skip


def _swin() -> t.SwinConfig:
    return t.SwinConfig(
        image_size=64, embed_dim=8, depths=[1, 1, 1, 1], num_heads=[1, 1, 1, 1], window_size=2,
        out_features=["stage1", "stage2", "stage3", "stage4"],
    )  # fmt: skip


def _saved(kind: type, config: t.PreTrainedConfig, folder: Path) -> t.PreTrainedModel:
    torch.manual_seed(9)
    model = kind(config).eval()
    with torch.no_grad():
        for parameter in model.parameters():  # initial weights are so small that all answers are alike
            parameter.add_(0.1 * torch.randn_like(parameter))
        for name, parameter in model.named_parameters():
            if name.endswith(("class_predictor.bias", "class_embed.bias")):
                parameter[-1] = -5  # no query finds nothing
    model.save_pretrained(folder)
    return model
