#!/usr/bin/env python3
"""Trains an adapter of the default model: small additions to its weights that make it better at one of its requests.

    train.py DATA.jsonl... MODEL.gguf ADAPTER.gguf [--start ADAPTER.gguf] [--task TASK] [--device cuda] [--epochs N]
        [--minutes M] [--measure OTHER.jsonl] [--seed S]

DATA.jsonl is the output of the example `training_data` of longstep-eval, or of `synthetic.py`. The weights of the model stay as they are (the
dequantized ones of the file, in bfloat16); two thin matrices are trained beside each of its linear maps (LoRA). Many
instructions of one scene share the tokens before them: one sequence holds the scene once and each instruction as a branch
that sees the scene and itself. So a processor of two cores trains on about a thousand instructions an hour, and a graphics card
of 2023 on as many in half a minute.

`--measure` counts, at the end, how many answers of other data would be given word for word (nothing is held to a grammar here).

Needs torch, numpy, gguf and tokenizers (requirements.txt).
"""

import argparse
import collections
import itertools
import json
import math
import random
import time

import gguf
import numpy
import torch
import torch.nn.functional as F
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers

# Names of the linear maps of a block in a GGUF file.
MAPS = ["attn_q", "attn_k", "attn_v", "attn_output", "ffn_gate", "ffn_up", "ffn_down"]
SPLIT = (
    r"(?i:'s|'t|'re|'ve|'m|'ll|'d)|[^\r\n\p{L}\p{N}]?\p{L}+|\p{N}| ?[^\s\p{L}\p{N}]+[\r\n]*|\s*[\r\n]+|\s+(?!\S)|\s+"
)


class Vocabulary:
    """The tokenizer of a GGUF file with byte-level BPE."""

    def __init__(self, fields):
        tokens = [bytes(fields["tokenizer.ggml.tokens"].parts[place]).decode()
                  for place in fields["tokenizer.ggml.tokens"].data]
        merges = [tuple(bytes(fields["tokenizer.ggml.merges"].parts[place]).decode().split(" "))
                  for place in fields["tokenizer.ggml.merges"].data]
        self.index = {token: number for number, token in enumerate(tokens)}
        self.coder = Tokenizer(models.BPE(vocab=self.index, merges=merges, fuse_unk=False, byte_fallback=False))
        self.coder.pre_tokenizer = pre_tokenizers.Sequence([
            pre_tokenizers.Split(Regex(SPLIT), behavior="isolated", invert=False),
            pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False),
        ])
        self.coder.decoder = decoders.ByteLevel()

    def text(self, text):
        return self.coder.encode(text).ids

    def special(self, name):
        return [self.index[name]]

    def message(self, role, text, is_open=False):
        """The tokens of a message of the chat template; an open one has no end."""
        tokens = self.special("<|im_start|>") + self.text(f"{role}\n{text}")
        return tokens if is_open else tokens + self.special("<|im_end|>") + self.text("\n")


class Added(torch.autograd.Function):
    """A frozen linear map and its addition in one pass each way: y = x W^T + bias + scale (x A^T) B^T."""

    @staticmethod
    def forward(ctx, x, weight, bias, a, b, scale):
        a, b = a.to(x.dtype), (b * scale).to(x.dtype)
        low = x @ a.t()
        ctx.save_for_backward(x, weight, a, b, low)
        ctx.scale = scale
        return F.linear(x, weight, bias).addmm_(low, b.t())

    @staticmethod
    def backward(ctx, gradient):
        x, weight, a, b, low = ctx.saved_tensors
        narrow = gradient @ b
        of_a = narrow.t() @ x
        of_b = gradient.t() @ low
        of_x = (gradient @ weight).addmm_(narrow, a) if ctx.needs_input_grad[0] else None
        return of_x, None, None, of_a.float(), of_b.float() * ctx.scale, None


class Lora(torch.nn.Module):
    """A frozen linear map with a trained addition of low rank."""

    def __init__(self, weight, bias, rank, alpha):
        super().__init__()
        self.weight, self.bias, self.scale = weight, bias, alpha / rank
        out, into = weight.shape
        self.a = torch.nn.Parameter((torch.randn(rank, into) / math.sqrt(into)).to(weight.device))
        self.b = torch.nn.Parameter(torch.zeros(out, rank, device=weight.device))

    def forward(self, x):
        return Added.apply(x, self.weight, self.bias, self.a, self.b, self.scale)


def norm(x, weight, epsilon):
    wide = x.float()
    return (wide * torch.rsqrt(wide.pow(2).mean(-1, keepdim=True) + epsilon)).to(x.dtype) * weight


class Model(torch.nn.Module):
    """A Qwen2 model whose linear maps have additions."""

    def __init__(self, reader, rank, alpha, device):
        super().__init__()
        tensors = {tensor.name: tensor for tensor in reader.tensors}
        number = lambda name: int(reader.fields[f"qwen2.{name}"].parts[-1][0])

        def get(name):
            if name not in tensors:
                return None
            tensor = tensors[name]
            plain = gguf.quants.dequantize(tensor.data, tensor.tensor_type)
            return torch.from_numpy(numpy.ascontiguousarray(plain)).to(torch.bfloat16).to(device)

        self.heads, self.pairs = number("attention.head_count"), number("attention.head_count_kv")
        self.epsilon = float(reader.fields["qwen2.attention.layer_norm_rms_epsilon"].parts[-1][0])
        self.base = float(reader.fields["qwen2.rope.freq_base"].parts[-1][0])
        self.embedding = get("token_embd.weight")
        self.output = get("output.weight")
        self.output = self.embedding if self.output is None else self.output
        self.last = get("output_norm.weight")
        self.norms, self.maps = [], torch.nn.ModuleList()
        for block in range(number("block_count")):
            prefix = f"blk.{block}."
            self.norms.append((get(prefix + "attn_norm.weight"), get(prefix + "ffn_norm.weight")))
            self.maps.append(torch.nn.ModuleDict({
                name: Lora(get(f"{prefix}{name}.weight"), get(f"{prefix}{name}.bias"), rank, alpha) for name in MAPS
            }))

    def turned(self, x, cos, sin):
        one, two = x.chunk(2, dim=-1)
        return x * cos + torch.cat((-two, one), dim=-1) * sin

    def forward(self, tokens, positions, mask, wanted):
        """The logits behind the wanted places of one sequence."""
        x = self.embedding[tokens]
        length = x.shape[0]
        size = x.shape[1] // self.heads
        speeds = self.base ** (-torch.arange(0, size, 2, device=x.device).float() / size)
        angles = positions.float()[:, None] * speeds[None]
        angles = torch.cat((angles, angles), dim=-1)
        cos, sin = angles.cos().to(x.dtype), angles.sin().to(x.dtype)
        for (before, middle), maps in zip(self.norms, self.maps):
            h = norm(x, before, self.epsilon)
            heads = lambda name, count: maps[name](h).view(length, count, size).transpose(0, 1)
            q = self.turned(heads("attn_q", self.heads), cos, sin)
            k = self.turned(heads("attn_k", self.pairs), cos, sin)
            v = heads("attn_v", self.pairs)
            times = self.heads // self.pairs
            k, v = k.repeat_interleave(times, 0), v.repeat_interleave(times, 0)
            seen = F.scaled_dot_product_attention(q[None], k[None], v[None], attn_mask=mask[None, None])[0]
            x = x + maps["attn_output"](seen.transpose(0, 1).reshape(length, -1))
            h = norm(x, middle, self.epsilon)
            x = x + maps["ffn_down"](F.silu(maps["ffn_gate"](h)) * maps["ffn_up"](h))
        return F.linear(norm(x[wanted], self.last, self.epsilon), self.output).float()


def mixed(text, chance):
    """A text whose lists have their lines in another order."""
    lines = []
    for is_list, run in itertools.groupby(text.split("\n"), lambda line: line.startswith("- ")):
        own = list(run)
        if is_list:
            chance.shuffle(own)
        lines += own
    return "\n".join(lines)


def some(turns, most, chance):
    """At most so many of the examples; all where `most` is None. "any" is none of them in two fifths of the draws, else any number."""
    if most is None:
        return turns
    if most != "any":
        return chance.sample(turns, min(len(turns), chance.randint(0, most)))
    if chance.random() < 0.4:
        return []
    if chance.random() < 0.5:
        return chance.sample(turns, chance.randint(0, len(turns)))
    return [turn for turn in turns if chance.random() < 0.7]


def sequence(vocabulary, cases, chance, most, is_mixed=False):
    """One sequence: what the cases share, then each case as a branch, or as a branch of the plan that it is about. With `most`
    examples at most ([`some`]); `is_mixed` puts the goals and the things of the scene in another order. Returns
    tokens, positions, mask, the places whose next token is learned, these tokens, and the number of the case of each."""
    fixed = cases[0]["fixed"]
    turns = list(zip(fixed[1::2], fixed[2::2]))
    shown = some(turns, most, chance)
    own = (lambda text: mixed(text, chance)) if is_mixed else lambda text: text
    tokens = vocabulary.message(fixed[0][0], own(fixed[0][1]))
    for question, answer in shown:
        tokens += vocabulary.message(*question) + vocabulary.message(*answer)
    tokens += vocabulary.message("user", own(cases[0]["lead"]), is_open=True)
    shared = len(tokens)
    positions, branch, parent = list(range(shared)), [0] * shared, [0] * shared
    places, targets, owners = [], [], []
    plans = {}
    for number, case in enumerate(cases, start=1):
        begin, above = shared, 0
        if "plan" in case:
            if case["plan"] not in plans:
                own = vocabulary.text(case["plan"])
                plans[case["plan"]] = (shared + len(own), len(cases) + 1 + len(plans))
                positions += range(shared, shared + len(own))
                branch += [plans[case["plan"]][1]] * len(own)
                parent += [0] * len(own)
                tokens += own
            begin, above = plans[case["plan"]]
        before = vocabulary.text(case["instruction"])
        # What was answered, and what was said about it.
        for reply, message in case.get("rounds", []):
            before += vocabulary.special("<|im_end|>") + vocabulary.text("\n") + vocabulary.message("assistant", reply)
            before += vocabulary.message("user", message, is_open=True)
        before += vocabulary.special("<|im_end|>") + vocabulary.text("\n")
        before += vocabulary.message("assistant", "", is_open=True)
        if case["answer"] is None:
            answer = vocabulary.text("question:")
        else:
            answer = vocabulary.text(case["answer"]) + vocabulary.special("<|im_end|>")
        own = before + answer
        start = len(tokens) + len(before)
        places += range(start - 1, start - 1 + len(answer))
        targets += answer
        owners += [number - 1] * len(answer)
        positions += range(begin, begin + len(own))
        branch += [number] * len(own)
        parent += [above] * len(own)
        tokens += own
    order, branch, parent = torch.arange(len(tokens)), torch.tensor(branch), torch.tensor(parent)
    seen = (branch[None] == 0) | (branch[:, None] == branch[None]) | (parent[:, None] == branch[None])
    mask = (order[:, None] >= order[None]) & seen
    return torch.tensor(tokens), torch.tensor(positions), mask, torch.tensor(places), torch.tensor(targets), owners


def joined(sequences):
    """Several sequences as one; none sees another."""
    tokens, positions, masks, places, targets, _ = zip(*sequences)
    starts = list(itertools.accumulate([0, *map(len, tokens[:-1])]))
    places = [own + start for own, start in zip(places, starts)]
    return torch.cat(tokens), torch.cat(positions), torch.block_diag(*masks).bool(), torch.cat(places), torch.cat(targets), []


def predicted(model, tokens, positions, mask, places, targets):
    """The logits behind the places of a sequence and the loss, summed over the targets; and the targets where the model is."""
    device = model.embedding.device
    logits = model(tokens.to(device), positions.to(device), mask.to(device), places.to(device))
    targets = targets.to(device)
    return logits, F.cross_entropy(logits, targets, reduction="sum"), targets


def packs(cases, size, chance):
    """The cases in groups of one scene, in random order."""
    scenes = {}
    for case in cases:
        scenes.setdefault((case["suite"], case["lead"]), []).append(case)
    groups = []
    for own in scenes.values():
        chance.shuffle(own)
        count = max(1, round(len(own) / size))
        if "plan" in own[0]:
            # What is said about one plan stays together.
            own.sort(key=lambda case: case["plan"])
            groups += [own[len(own) * start // count:len(own) * (start + 1) // count] for start in range(count)]
        else:
            groups += [own[start::count] for start in range(count)]
    chance.shuffle(groups)
    return groups


def save(path, model, rank, alpha, task):
    """Writes the additions as llama.cpp reads them.

    The thin matrix before the rank has rows of a whole input, so it is written in 8 bits (Q8_0: blocks of 32), a fifth of the file
    less than in 16; the one after it has rows of the rank, shorter than a block, and stays in 16.
    """
    writer = gguf.GGUFWriter(path, "qwen2")
    writer.add_string("general.type", "adapter")
    writer.add_string("longstep.task", task)
    writer.add_string("adapter.type", "lora")
    writer.add_float32("adapter.lora.alpha", float(alpha))
    for block, maps in enumerate(model.maps):
        for name in MAPS:
            lora = maps[name]
            for part, value in (("a", lora.a), ("b", lora.b)):
                plain = value.detach().to(torch.float16).cpu().numpy()
                kind = gguf.GGMLQuantizationType.Q8_0 if part == "a" else gguf.GGMLQuantizationType.F16
                written = gguf.quants.quantize(plain.astype(numpy.float32), kind)
                writer.add_tensor(f"blk.{block}.{name}.weight.lora_{part}", written, raw_dtype=kind)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def load(path, model):
    """Begins with the additions of an adapter."""
    tensors = {tensor.name: gguf.quants.dequantize(tensor.data, tensor.tensor_type)
               for tensor in gguf.GGUFReader(path).tensors}
    for block, maps in enumerate(model.maps):
        for name in MAPS:
            for part, value in (("a", maps[name].a), ("b", maps[name].b)):
                plain = tensors[f"blk.{block}.{name}.weight.lora_{part}"]
                value.data.copy_(torch.from_numpy(plain))


def measure(path, model, vocabulary, chance, size):
    """Prints how many answers of these data would be given word for word, of each suite, with all examples."""
    right, count, total_loss = collections.Counter(), collections.Counter(), 0.0
    [question, *_] = vocabulary.text("question:")
    # Cases that expect a goal and get a question, and the other way round.
    asked, answered = 0, 0
    for group in packs(read_cases(path), size, chance):
        *parts, owners = sequence(vocabulary, group, chance, None)
        with torch.no_grad():
            logits, loss, targets = predicted(model, *parts)
        total_loss += loss.item()
        said = [([], []) for _ in group]
        for owner, best, target in zip(owners, logits.argmax(-1).tolist(), targets.tolist()):
            said[owner][0].append(best)
            said[owner][1].append(target)
        for case, (best, target) in zip(group, said):
            count[case["suite"]] += 1
            right[case["suite"]] += best == target
            is_question = best[0] == question
            asked += is_question and case["answer"] is not None
            answered += not is_question and case["answer"] is None
    for suite in sorted(count):
        print(f"{suite}: {right[suite]} of {count[suite]}")
    total = sum(count.values())
    print(f"{path}: {sum(right.values())} of {total} word for word, {asked} asked about without need, {answered} answered instead of "
          f"asked about, loss {total_loss / total:.4f} a case", flush=True)


def read_cases(path):
    with open(path) as lines:
        return [json.loads(line) for line in lines]


def main():
    reads = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    reads.add_argument("data", nargs="+")
    reads.add_argument("model")
    reads.add_argument("adapter")
    reads.add_argument("--task", choices=["goals", "description", "plans"], default="goals")
    reads.add_argument("--start", help="an adapter to go on from")
    reads.add_argument("--device", default="cpu")
    reads.add_argument("--once", action="append", default=[], help="further data, seen once in all epochs together")
    reads.add_argument("--minutes", type=float, default=60)
    reads.add_argument("--epochs", type=float, default=1)
    reads.add_argument("--rank", type=int, default=4)
    reads.add_argument("--rate", type=float, default=3e-4)
    reads.add_argument("--pack", type=int, default=12)
    reads.add_argument("--scenes", type=int, default=1, help="scenes in one step: 4 fill a card")
    reads.add_argument("--examples", type=lambda text: text if text == "any" else int(text), default=3, help="at most so many, or `any`")
    reads.add_argument("--mixed", type=float, default=0, help="the share of packs whose lists are put in another order")
    reads.add_argument("--seed", type=int, default=1)
    reads.add_argument("--measure", action="append", default=[], help="other data, to be measured at the end")
    read = reads.parse_args()
    torch.manual_seed(read.seed)
    chance = random.Random(read.seed)
    alpha = 2 * read.rank
    reader = gguf.GGUFReader(read.model)
    vocabulary = Vocabulary(reader.fields)
    model = Model(reader, read.rank, alpha, read.device)
    if read.start:
        load(read.start, model)
    cases = [case for path in read.data for case in read_cases(path)]
    count = max(1, math.ceil(read.epochs))
    once = packs([case for path in read.once for case in read_cases(path)], read.pack, chance)
    rounds = []
    for epoch in range(count):
        own = packs(cases, read.pack, chance) + once[epoch::count]
        chance.shuffle(own)
        rounds.append(own)
    groups = list(itertools.chain(*rounds))[:round(read.epochs * len(rounds[0]))]
    steps = [groups[start:start + read.scenes] for start in range(0, len(groups), read.scenes)]
    parameters = [p for p in model.parameters() if p.requires_grad]
    optimizer = torch.optim.AdamW(parameters, lr=read.rate, betas=(0.9, 0.99), weight_decay=0.0)
    start, done, tokens_done = time.monotonic(), 0, 0
    waiting, total = 0, 0
    print(f"{len(cases)} cases, {len(groups)} packs", flush=True)

    for step, of_step in enumerate(steps):
        elapsed = time.monotonic() - start
        # The rate falls by the packs or by the time, whichever is further.
        progress = max(step / len(steps), elapsed / (60 * read.minutes))
        if progress >= 1:
            break
        rate = read.rate * min(1.0, (step + 1) / 8) * (0.05 + 0.95 * 0.5 * (1 + math.cos(math.pi * progress)))
        for part in optimizer.param_groups:
            part["lr"] = rate
        *parts, _ = joined([
            sequence(vocabulary, group, chance, read.examples, chance.random() < read.mixed) for group in of_step
        ])
        logits, loss, targets = predicted(model, *parts)
        loss.backward()
        waiting, total = waiting + sum(map(len, of_step)), total + len(targets)
        # Scenes of few instructions share a step.
        if waiting >= 0.7 * read.pack or step + 1 == len(steps):
            for parameter in parameters:
                parameter.grad /= total
            size = torch.nn.utils.clip_grad_norm_(parameters, 1.0)
            # One step that is not a number would spoil all that follow (seen on a graphics card).
            if torch.isfinite(size):
                optimizer.step()
            else:
                print(f"step {step} is left out: its gradient is not finite", flush=True)
            optimizer.zero_grad()
            waiting, total = 0, 0
        done += sum(map(len, of_step))
        tokens_done += len(parts[0])
        is_twentieth = step % 20 == 19
        # On a card, neither the text nor a save is worth waiting for at each step.
        if read.device == "cpu" or is_twentieth:
            elapsed = time.monotonic() - start
            right = (logits.argmax(-1) == targets).float().mean().item()
            print(f"{elapsed:6.0f} s  step {step}  cases {done}  tokens {tokens_done} ({tokens_done / elapsed:.1f}/s)  "
                  f"loss {loss.item() / len(targets):.3f}  right tokens {right:.3f}", flush=True)
        if read.device == "cpu" and is_twentieth:
            save(read.adapter + ".part", model, read.rank, alpha, read.task)
    save(read.adapter, model, read.rank, alpha, read.task)
    for path in read.measure:
        measure(path, model, vocabulary, chance, read.pack)


if __name__ == "__main__":
    main()
