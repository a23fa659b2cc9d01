import collections, itertools, json, math, random
import gguf, numpy as np
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers
SPLIT = (r"(?i:'s|'t|'re|'ve|'m|'ll|'d)|[^\r\n\p{L}\p{N}]?\p{L}+|\p{N}| ?[^\s\p{L}\p{N}]+[\r\n]*|\s*[\r\n]+|\s+(?!\S)|\s+")
class Vocabulary:
    def __init__(self, fields):
        tokens = [bytes(fields["tokenizer.ggml.tokens"].parts[p]).decode() for p in fields["tokenizer.ggml.tokens"].data]
        merges = [tuple(bytes(fields["tokenizer.ggml.merges"].parts[p]).decode().split(" ")) for p in fields["tokenizer.ggml.merges"].data]
        self.index = {t: n for n, t in enumerate(tokens)}
        self.coder = Tokenizer(models.BPE(vocab=self.index, merges=merges, fuse_unk=False, byte_fallback=False))
        self.coder.pre_tokenizer = pre_tokenizers.Sequence([pre_tokenizers.Split(Regex(SPLIT), behavior="isolated", invert=False), pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False)])
        self.coder.decoder = decoders.ByteLevel(); self.cache = {}
    def text(self, t):
        r = self.cache.get(t)
        if r is None: r = self.cache[t] = self.coder.encode(t).ids
        return list(r)
    def special(self, n): return [self.index[n]]
    def message(self, role, text, is_open=False):
        t = self.special("<|im_start|>") + self.text(f"{role}\n{text}")
        return t if is_open else t + self.special("<|im_end|>") + self.text("\n")
def mixed(text, chance):
    lines = []
    for is_list, run in itertools.groupby(text.split("\n"), lambda l: l.startswith("- ")):
        own = list(run)
        if is_list: chance.shuffle(own)
        lines += own
    return "\n".join(lines)
def sequence(voc, cases, chance, most, is_mixed=False):
    fixed = cases[0]["fixed"]; turns = list(zip(fixed[1::2], fixed[2::2]))
    if most is None: shown = turns
    elif most == "any" and chance.random() < .4: shown = []
    elif most == "any":   # none to all, in random order half of the time
        n = chance.randint(0, len(turns)); shown = chance.sample(turns, n) if chance.random() < .5 else [t for t in turns if chance.random() < .7]
    else: shown = chance.sample(turns, min(len(turns), chance.randint(0, most)))
    own = (lambda t: mixed(t, chance)) if is_mixed else (lambda t: t)
    tokens = voc.message(fixed[0][0], own(fixed[0][1]))
    for q, a in shown: tokens += voc.message(*q) + voc.message(*a)
    tokens += voc.message("user", own(cases[0]["lead"]), is_open=True)
    shared = len(tokens); positions = list(range(shared)); branch = [0] * shared; parent = [0] * shared
    places, targets, owners = [], [], []; plans = {}
    for number, case in enumerate(cases, 1):
        begin, above = shared, 0
        if "plan" in case:
            if case["plan"] not in plans:
                o = voc.text(case["plan"]); plans[case["plan"]] = (shared + len(o), len(cases) + 1 + len(plans))
                positions += range(shared, shared + len(o)); branch += [plans[case["plan"]][1]] * len(o); parent += [0] * len(o); tokens += o
            begin, above = plans[case["plan"]]
        said = voc.text(case["instruction"])
        for reply, message in case.get("rounds", []):
            said += voc.special("<|im_end|>") + voc.text("\n") + voc.message("assistant", reply) + voc.message("user", message, is_open=True)
        before = said + voc.special("<|im_end|>") + voc.text("\n") + voc.message("assistant", "", is_open=True)
        answer = voc.text("question:") if case["answer"] is None else voc.text(case["answer"]) + voc.special("<|im_end|>")
        o = before + answer; start = len(tokens) + len(before)
        places += range(start - 1, start - 1 + len(answer)); targets += answer; owners += [number - 1] * len(answer)
        positions += range(begin, begin + len(o)); branch += [number] * len(o); parent += [above] * len(o); tokens += o
    A = lambda x: np.array(x, dtype=np.int32)
    return dict(tokens=A(tokens), positions=A(positions), branch=A(branch), parent=A(parent), places=A(places), targets=A(targets), owners=A(owners))
def packs(cases, size, chance):
    scenes = {}
    for c in cases: scenes.setdefault((c["suite"], c["lead"]), []).append(c)
    groups = []
    for own in scenes.values():
        chance.shuffle(own); count = max(1, round(len(own) / size))
        if "plan" in own[0]:
            own.sort(key=lambda c: c["plan"]); groups += [own[len(own) * s // count:len(own) * (s + 1) // count] for s in range(count)]
        else: groups += [own[s::count] for s in range(count)]
    chance.shuffle(groups); return groups
