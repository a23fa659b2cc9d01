"""A Qwen2 model with a LoRA adapter: the frozen weights come from a GGUF file, the adapter is read from and written to one.

Shapes in the docstrings: T tokens of one sequence, D the hidden size, H query heads, K key-value heads, E = D / H the size of a head,
R the rank of the adapter, V the size of the vocabulary.
"""

import math
from collections.abc import Mapping
from typing import Any, cast

import gguf
import numpy
import torch
import torch.nn.functional as F
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers
from torch import Tensor

# The linear layers of a block, by their names in a GGUF file.
LINEAR_LAYERS = ("attn_q", "attn_k", "attn_v", "attn_output", "ffn_gate", "ffn_up", "ffn_down")
PRE_TOKENIZER = (
    r"(?i:'s|'t|'re|'ve|'m|'ll|'d)|[^\r\n\p{L}\p{N}]?\p{L}+|\p{N}| ?[^\s\p{L}\p{N}]+[\r\n]*|\s*[\r\n]+|\s+(?!\S)|\s+"
)


class QwenTokenizer:
    """The tokenizer of a GGUF file (byte-level BPE) with the chat template of Qwen2."""

    def __init__(self, fields: Mapping[str, gguf.ReaderField]) -> None:
        tokens, merges = (
            [bytes(fields[key].parts[index]).decode() for index in fields[key].data]
            for key in ("tokenizer.ggml.tokens", "tokenizer.ggml.merges")
        )
        self.token_ids = {token: token_id for token_id, token in enumerate(tokens)}
        pairs = [cast(tuple[str, str], tuple(merge.split(" "))) for merge in merges]
        self.bpe = Tokenizer(models.BPE(vocab=self.token_ids, merges=pairs, fuse_unk=False, byte_fallback=False))
        self.bpe.pre_tokenizer = pre_tokenizers.Sequence([
            pre_tokenizers.Split(Regex(PRE_TOKENIZER), behavior="isolated", invert=False),
            pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False),
        ])
        self.bpe.decoder = decoders.ByteLevel()

    def encode(self, text: str) -> list[int]:
        return list(self.bpe.encode(text).ids)

    def encode_end(self) -> list[int]:
        """Returns the token that ends a message."""
        return [self.token_ids["<|im_end|>"]]

    def encode_message(self, role: str, text: str, is_open: bool = False) -> list[int]:
        """Returns the tokens of a message of the chat template; an open message has no end."""
        tokens = [self.token_ids["<|im_start|>"]] + self.encode(f"{role}\n{text}")
        return tokens if is_open else tokens + self.encode_end() + self.encode("\n")


class LoraFunction(torch.autograd.Function):
    """A frozen linear layer and its adapter: y = x W^T + bias + scale (x A^T) B^T, with gradients for x, A and B only."""

    @staticmethod
    def forward(ctx: Any, x: Tensor, weight: Tensor, bias: Tensor | None, lora_a: Tensor, lora_b: Tensor, scale: float) -> Tensor:
        """x [T, in], weight [out, in], bias [out], lora_a [R, in], lora_b [out, R] -> [T, out]."""
        lora_a, scaled_b = lora_a.to(x.dtype), (lora_b * scale).to(x.dtype)
        hidden = x @ lora_a.t()
        ctx.save_for_backward(x, weight, lora_a, scaled_b, hidden)
        ctx.scale = scale
        return F.linear(x, weight, bias).addmm_(hidden, scaled_b.t())

    @staticmethod
    def backward(ctx: Any, *grad_outputs: Tensor) -> tuple[Tensor | None, None, None, Tensor, Tensor, None]:
        """grad_outputs is one gradient [T, out]."""
        [grad_output] = grad_outputs
        x, weight, lora_a, scaled_b, hidden = ctx.saved_tensors
        grad_hidden = grad_output @ scaled_b
        grad_a = grad_hidden.t() @ x
        grad_b = grad_output.t() @ hidden
        grad_x = (grad_output @ weight).addmm_(grad_hidden, lora_a) if ctx.needs_input_grad[0] else None
        return grad_x, None, None, grad_a.float(), grad_b.float() * ctx.scale, None


class LoraLinear(torch.nn.Module):
    """A frozen linear layer with a trained addition of low rank. B is zero at first, so the addition is, too."""

    def __init__(self, weight: Tensor, bias: Tensor | None, rank: int, alpha: float) -> None:
        super().__init__()
        self.weight, self.bias, self.scale = weight, bias, alpha / rank
        out_features, in_features = weight.shape
        self.lora_a = torch.nn.Parameter((torch.randn(rank, in_features) / math.sqrt(in_features)).to(weight.device))
        self.lora_b = torch.nn.Parameter(torch.zeros(out_features, rank, device=weight.device))

    def forward(self, x: Tensor) -> Tensor:
        """x [T, in] -> [T, out]."""
        y: Tensor = LoraFunction.apply(x, self.weight, self.bias, self.lora_a, self.lora_b, self.scale)
        return y


def rms_norm(x: Tensor, weight: Tensor, eps: float) -> Tensor:
    """x [T, D], weight [D] -> [T, D]; computed in 32 bits."""
    wide = x.float()
    return (wide * torch.rsqrt(wide.pow(2).mean(-1, keepdim=True) + eps)).to(x.dtype) * weight


def rotary_cos_sin(position_ids: Tensor, head_dim: int, rope_theta: float, dtype: torch.dtype) -> tuple[Tensor, Tensor]:
    """Returns the cosines and sines of the rotary embedding: position_ids [T] -> two of [T, E]."""
    inv_freq = rope_theta ** (-torch.arange(0, head_dim, 2, device=position_ids.device).float() / head_dim)
    freqs = position_ids.float()[:, None] * inv_freq[None]
    angles = torch.cat((freqs, freqs), dim=-1)
    return angles.cos().to(dtype), angles.sin().to(dtype)


def apply_rotary(x: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    """Rotates the pairs of dimensions (i, i + E / 2): x [heads, T, E], cos and sin [T, E] -> [heads, T, E]."""
    first_half, second_half = x.chunk(2, dim=-1)
    return x * cos + torch.cat((-second_half, first_half), dim=-1) * sin


class Block(torch.nn.Module):
    """One transformer block: attention with grouped queries, and a gated feed-forward network."""

    def __init__(
        self, attn_norm: Tensor, ffn_norm: Tensor, layers: Mapping[str, LoraLinear], num_heads: int, num_kv_heads: int, eps: float,
    ) -> None:
        super().__init__()
        self.attn_norm, self.ffn_norm, self.eps = attn_norm, ffn_norm, eps
        self.num_heads, self.num_kv_heads = num_heads, num_kv_heads
        self.layers = torch.nn.ModuleDict(dict(layers))

    def project(self, name: str, x: Tensor, heads: int) -> Tensor:
        """Returns the heads of a projection: x [T, D] -> [heads, T, E]."""
        projected: Tensor = self.layers[name](x)
        return projected.view(x.shape[0], heads, -1).transpose(0, 1)

    def attention(self, x: Tensor, cos: Tensor, sin: Tensor, attention_mask: Tensor) -> Tensor:
        """x [T, D], cos and sin [T, E], attention_mask [T, T] -> [T, D]."""
        query = apply_rotary(self.project("attn_q", x, self.num_heads), cos, sin)
        key = apply_rotary(self.project("attn_k", x, self.num_kv_heads), cos, sin)
        value = self.project("attn_v", x, self.num_kv_heads)
        group_size = self.num_heads // self.num_kv_heads
        key, value = key.repeat_interleave(group_size, 0), value.repeat_interleave(group_size, 0)
        heads = F.scaled_dot_product_attention(query[None], key[None], value[None], attn_mask=attention_mask[None, None])[0]
        output: Tensor = self.layers["attn_output"](heads.transpose(0, 1).reshape(x.shape[0], -1))
        return output

    def feed_forward(self, x: Tensor) -> Tensor:
        """x [T, D] -> [T, D]."""
        output: Tensor = self.layers["ffn_down"](F.silu(self.layers["ffn_gate"](x)) * self.layers["ffn_up"](x))
        return output

    def forward(self, x: Tensor, cos: Tensor, sin: Tensor, attention_mask: Tensor) -> Tensor:
        """x [T, D], cos and sin [T, E], attention_mask [T, T] -> [T, D]."""
        x = x + self.attention(rms_norm(x, self.attn_norm, self.eps), cos, sin, attention_mask)
        return x + self.feed_forward(rms_norm(x, self.ffn_norm, self.eps))


class Qwen2(torch.nn.Module):
    """A frozen Qwen2 model whose linear layers have adapters."""

    def __init__(
        self, reader: gguf.GGUFReader, rank: int, alpha: float, device: str, dtype: torch.dtype = torch.bfloat16,
    ) -> None:
        super().__init__()
        tensors = {tensor.name: tensor for tensor in reader.tensors}

        def metadata(name: str) -> Any:
            return reader.fields[f"qwen2.{name}"].parts[-1][0]

        def optional_weight(name: str) -> Tensor | None:
            if name not in tensors:
                return None
            dequantized = gguf.quants.dequantize(tensors[name].data, tensors[name].tensor_type)
            return torch.tensor(dequantized).to(dtype).to(device)

        def weight(name: str) -> Tensor:
            found = optional_weight(name)
            if found is None:
                raise KeyError(f"the model has no tensor `{name}`")
            return found

        num_heads, num_kv_heads = int(metadata("attention.head_count")), int(metadata("attention.head_count_kv"))
        self.eps = float(metadata("attention.layer_norm_rms_epsilon"))
        self.rope_theta = float(metadata("rope.freq_base"))
        self.embedding = weight("token_embd.weight")
        output_weight = optional_weight("output.weight")
        # Small models share the matrix of the embedding.
        self.output_weight = self.embedding if output_weight is None else output_weight
        self.output_norm = weight("output_norm.weight")
        self.head_dim = self.embedding.shape[1] // num_heads
        self.blocks = torch.nn.ModuleList()
        for index in range(int(metadata("block_count"))):
            prefix = f"blk.{index}."
            layers = {
                name: LoraLinear(weight(f"{prefix}{name}.weight"), optional_weight(f"{prefix}{name}.bias"), rank, alpha)
                for name in LINEAR_LAYERS
            }
            norms = weight(prefix + "attn_norm.weight"), weight(prefix + "ffn_norm.weight")
            self.blocks.append(Block(*norms, layers, num_heads, num_kv_heads, self.eps))

    def forward(self, input_ids: Tensor, position_ids: Tensor, attention_mask: Tensor, logit_positions: Tensor) -> Tensor:
        """Returns the logits for the tokens that follow the wanted ones of N positions in one sequence.

        input_ids and position_ids [T], attention_mask [T, T] (true where the row's token sees the column's), logit_positions [N]
        -> [N, V].
        """
        x = self.embedding[input_ids]
        cos, sin = rotary_cos_sin(position_ids, self.head_dim, self.rope_theta, x.dtype)
        for block in self.blocks:
            x = block(x, cos, sin, attention_mask)
        return F.linear(rms_norm(x[logit_positions], self.output_norm, self.eps), self.output_weight).float()

    def lora_layers(self) -> dict[str, LoraLinear]:
        """Returns the linear layers by the names of their weights in a GGUF file."""
        return {
            f"blk.{index}.{name}.weight": cast(LoraLinear, cast(Block, block).layers[name])
            for index, block in enumerate(self.blocks)
            for name in LINEAR_LAYERS
        }


def save_adapter(path: str, model: Qwen2, alpha: float, task: str) -> None:
    """Writes the adapter as llama.cpp reads it.

    A has rows of a whole input, so it is written in 8 bits (Q8_0: blocks of 32), a fifth of the file less than in 16; B has rows of
    the rank, shorter than a block, and stays in 16.
    """
    writer = gguf.GGUFWriter(path, "qwen2")
    writer.add_string("general.type", "adapter")
    writer.add_string("longstep.task", task)
    writer.add_string("adapter.type", "lora")
    writer.add_float32("adapter.lora.alpha", float(alpha))
    for name, layer in model.lora_layers().items():
        for suffix, parameter, quantization in (
            ("lora_a", layer.lora_a, gguf.GGMLQuantizationType.Q8_0),
            ("lora_b", layer.lora_b, gguf.GGMLQuantizationType.F16),
        ):
            half = parameter.detach().to(torch.float16).cpu().numpy()
            quantized = gguf.quants.quantize(half.astype(numpy.float32), quantization)
            writer.add_tensor(f"{name}.{suffix}", quantized, raw_dtype=quantization)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def load_adapter(path: str, model: Qwen2) -> None:
    """Replaces the adapter of a model by one from a file."""
    tensors = {tensor.name: gguf.quants.dequantize(tensor.data, tensor.tensor_type) for tensor in gguf.GGUFReader(path).tensors}
    for name, layer in model.lora_layers().items():
        layer.lora_a.data.copy_(torch.from_numpy(tensors[f"{name}.lora_a"]))
        layer.lora_b.data.copy_(torch.from_numpy(tensors[f"{name}.lora_b"]))
