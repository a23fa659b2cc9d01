#!/usr/bin/env python3
"""Trains an adapter of the default model: LoRA matrices beside its linear layers that make it better at one of its requests.

    train.py DATA.jsonl... MODEL.gguf ADAPTER.gguf [--start ADAPTER.gguf] [--task TASK] [--device cuda] [--epochs N]
        [--minutes M] [--measure OTHER.jsonl] [--seed S]

DATA.jsonl is the output of `training_data` (lab/programs) or of `synthetic.py`. The weights of the model are those of its file,
dequantized to bfloat16, and stay as they are. Many instructions of one scene share the tokens before them: one sequence holds the scene
once and each instruction as a branch that sees the scene and itself (`sequences.py`). So a processor of two cores trains on about a
thousand instructions an hour, and a graphics card of 2023 on as many in half a minute.

`--measure` counts, at the end, the answers to other data that would be given word for word; no grammar constrains them here.

Needs torch, numpy, gguf and tokenizers (requirements.txt).
"""

import argparse
import collections
import itertools
import math
import random
import time
from collections.abc import Sequence

import gguf
import torch
import torch.nn.functional as F
from torch import Tensor

from qwen2 import Qwen2, QwenTokenizer, load_adapter, save_adapter
from sequences import QUESTION, Case, ExampleLimit, PackedSequence, concatenate, group_cases, pack_cases, read_cases

WARMUP_STEPS = 8
# The learning rate falls to this share of its peak.
FINAL_RATE = 0.05
MAX_GRADIENT_NORM = 1.0


def forward_loss(model: Qwen2, sequence: PackedSequence) -> tuple[Tensor, Tensor, Tensor]:
    """Returns the logits [N, V], the loss summed over the targets, and the targets [N] on the model's device."""
    device = model.embedding.device
    logits = model(
        sequence.input_ids.to(device),
        sequence.position_ids.to(device),
        sequence.attention_mask.to(device),
        sequence.target_positions.to(device),
    )
    targets = sequence.targets.to(device)
    return logits, F.cross_entropy(logits, targets, reduction="sum"), targets


def learning_rate(peak: float, step: int, progress: float) -> float:
    """Returns the learning rate of a step: a linear warmup, then a cosine over the progress from 0 to 1."""
    return peak * min(1.0, (step + 1) / WARMUP_STEPS) * (FINAL_RATE + (1 - FINAL_RATE) * 0.5 * (1 + math.cos(math.pi * progress)))


def draw_packs(
    cases: Sequence[Case], once: Sequence[Case], pack_size: int, epochs: float, rng: random.Random
) -> list[list[Case]]:
    """Draws the groups of cases for all epochs. The cases of `once` are spread over the epochs, the others are in each of them."""
    whole_epochs = max(1, math.ceil(epochs))
    once_groups = group_cases(once, pack_size, rng)
    rounds: list[list[list[Case]]] = []
    for epoch in range(whole_epochs):
        groups = group_cases(cases, pack_size, rng) + once_groups[epoch::whole_epochs]
        rng.shuffle(groups)
        rounds.append(groups)
    return list(itertools.chain(*rounds))[:round(epochs * len(rounds[0]))]


class Trainer:
    """Trains the adapter of a model, with gradients accumulated until a step has about a pack of cases."""

    def __init__(self, model: Qwen2, tokenizer: QwenTokenizer, options: argparse.Namespace, rng: random.Random) -> None:
        self.model, self.tokenizer, self.options, self.rng = model, tokenizer, options, rng
        self.parameters = [parameter for parameter in model.parameters() if parameter.requires_grad]
        self.optimizer = torch.optim.AdamW(self.parameters, lr=options.rate, betas=(0.9, 0.99), weight_decay=0.0)
        self.accumulated_cases = self.accumulated_targets = 0

    def train(self, groups: Sequence[list[Case]]) -> None:
        """Trains on groups of cases until they, or the minutes, are used up. Prints a line for the log."""
        options = self.options
        batches = [groups[first:first + options.scenes] for first in range(0, len(groups), options.scenes)]
        start, cases_done, tokens_done = time.monotonic(), 0, 0
        for step, batch in enumerate(batches):
            # The rate falls by the steps or by the time, whichever is further.
            progress = max(step / len(batches), (time.monotonic() - start) / (60 * options.minutes))
            if progress >= 1:
                break
            for group in self.optimizer.param_groups:
                group["lr"] = learning_rate(options.rate, step, progress)
            sequence = self.pack(batch)
            logits, loss, targets = forward_loss(self.model, sequence)
            loss.backward()  # type: ignore[no-untyped-call]
            case_count = sum(map(len, batch))
            self.accumulated_cases += case_count
            self.accumulated_targets += len(targets)
            # Scenes of few instructions share a step.
            if self.accumulated_cases >= 0.7 * options.pack or step + 1 == len(batches):
                self.update(step)
            cases_done, tokens_done = cases_done + case_count, tokens_done + len(sequence.input_ids)
            is_twentieth = step % 20 == 19
            # On a card, neither the text nor a save is worth waiting for at each step.
            if options.device == "cpu" or is_twentieth:
                elapsed = time.monotonic() - start
                accuracy = (logits.argmax(-1) == targets).float().mean().item()
                print(f"{elapsed:6.0f} s  step {step}  cases {cases_done}  tokens {tokens_done} ({tokens_done / elapsed:.1f}/s)  "
                      f"loss {loss.item() / len(targets):.3f}  right tokens {accuracy:.3f}", flush=True)
            if options.device == "cpu" and is_twentieth:
                save_adapter(options.adapter + ".part", self.model, 2 * options.rank, options.task)

    def pack(self, batch: Sequence[list[Case]]) -> PackedSequence:
        return concatenate([
            pack_cases(self.tokenizer, group, self.rng, self.options.examples, self.rng.random() < self.options.mixed) for group in batch
        ])

    def update(self, step: int) -> None:
        """Changes the adapter by the accumulated gradient, averaged over its targets."""
        for parameter in self.parameters:
            if parameter.grad is not None:
                parameter.grad /= self.accumulated_targets
        norm = torch.nn.utils.clip_grad_norm_(self.parameters, MAX_GRADIENT_NORM)
        # One step that is not a number would spoil all that follow (seen on a graphics card).
        if torch.isfinite(norm):
            self.optimizer.step()
        else:
            print(f"step {step} is left out: its gradient is not finite", flush=True)
        self.optimizer.zero_grad()
        self.accumulated_cases = self.accumulated_targets = 0


def measure(path: str, model: Qwen2, tokenizer: QwenTokenizer, rng: random.Random, pack_size: int) -> None:
    """Prints how many answers of other data would be given word for word, of each suite, with all examples."""
    right: collections.Counter[str] = collections.Counter()
    count: collections.Counter[str] = collections.Counter()
    total_loss = 0.0
    question_token = tokenizer.encode(QUESTION)[0]
    # Questions where a goal is expected, and goals where a question is.
    needless_questions = missing_questions = 0
    for group in group_cases(read_cases(path), pack_size, rng):
        sequence = pack_cases(tokenizer, group, rng, None)
        with torch.no_grad():
            logits, loss, targets = forward_loss(model, sequence)
        total_loss += loss.item()
        predicted: list[list[int]] = [[] for _ in group]
        expected: list[list[int]] = [[] for _ in group]
        for index, token, target in zip(sequence.target_cases, logits.argmax(-1).tolist(), targets.tolist()):
            predicted[index].append(token)
            expected[index].append(target)
        for case, own_predicted, own_expected in zip(group, predicted, expected):
            count[case["suite"]] += 1
            right[case["suite"]] += own_predicted == own_expected
            is_question = own_predicted[0] == question_token
            needless_questions += is_question and case["answer"] is not None
            missing_questions += not is_question and case["answer"] is None
    for suite in sorted(count):
        print(f"{suite}: {right[suite]} of {count[suite]}")
    print(f"{path}: {right.total()} of {count.total()} word for word, {needless_questions} needless questions, "
          f"{missing_questions} missing questions, loss {total_loss / count.total():.4f} a case", flush=True)


def example_limit(text: str) -> ExampleLimit:
    return "any" if text == "any" else int(text)


def parse_arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("data", nargs="+")
    parser.add_argument("model")
    parser.add_argument("adapter")
    parser.add_argument("--task", choices=["goals", "description", "plans"], default="goals")
    parser.add_argument("--start", help="an adapter to continue from")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--once", action="append", default=[], help="further data, spread over the epochs")
    parser.add_argument("--minutes", type=float, default=60, help="stop after so many")
    parser.add_argument("--epochs", type=float, default=1)
    parser.add_argument("--rank", type=int, default=4, help="of the adapter; its alpha is twice the rank")
    parser.add_argument("--rate", type=float, default=3e-4, help="peak learning rate")
    parser.add_argument("--pack", type=int, default=12, help="instructions of one scene in a sequence, about")
    parser.add_argument("--scenes", type=int, default=1, help="scenes in one step: 4 fill a card")
    parser.add_argument("--examples", type=example_limit, default=3, help="at most so many worked examples in a prompt, or `any`")
    parser.add_argument("--mixed", type=float, default=0, help="the share of sequences whose lists are put in another order")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--measure", action="append", default=[], help="other data, to be measured at the end")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse_arguments(arguments)
    torch.manual_seed(options.seed)
    rng = random.Random(options.seed)
    reader = gguf.GGUFReader(options.model)
    tokenizer = QwenTokenizer(reader.fields)
    alpha = 2 * options.rank
    model = Qwen2(reader, options.rank, alpha, options.device)
    if options.start:
        load_adapter(options.start, model)
    cases = [case for path in options.data for case in read_cases(path)]
    once = [case for path in options.once for case in read_cases(path)]
    groups = draw_packs(cases, once, options.pack, options.epochs, rng)
    print(f"{len(cases)} cases, {len(groups)} packs", flush=True)
    Trainer(model, tokenizer, options, rng).train(groups)
    save_adapter(options.adapter, model, alpha, options.task)
    for path in options.measure:
        measure(path, model, tokenizer, rng, options.pack)


if __name__ == "__main__":
    main()
