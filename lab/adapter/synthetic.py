#!/usr/bin/env python3
"""Makes robots from a lexicon, and what people say to them in five languages: training data for the words.

    synthetic.py DATA.jsonl OUT.jsonl [--robots N] [--cases N] [--seed S]

The things and places of a robot are drawn from `synthetic/nouns-*.tsv` (a name and a class, and in each language the ways to call it), its goals from
`synthetic/words-*.toml` (what is so afterwards, what it takes, and in each language sentences that ask for it or forbid it). DATA.jsonl is the output of
the example `training_data`: the end of its system text, which is the same for all robots, is taken from there. OUT.jsonl has the same form.

Most of it makes no sense ("vacuum the wardrobe"); what it teaches is words, cases and articles. A wish, two wishes, a wish with a prohibition, a
prohibition alone, an order, a question (things with one name, a thing that is not there, an act that is no goal), and what is said next (which
one, another one, further wishes, less).
"""

import argparse
import collections
import glob
import json
import pathlib
import random
import re
import tomllib

FOLDER = pathlib.Path(__file__).parent / "synthetic"
LANGUAGES = ["en", "de", "fr", "es", "ja"]
SHARES = [16, 22, 20, 20, 22]
PEOPLE = """Anna Ben Carla David Elena Fatma Georg Hanna Ivan Julia Kenji Lena Marco Nadia Olga Pablo Quentin Rosa Samir Tomas Ursula Viktor Wanda Yuki
Zoe Ahmed Amélie Jonas Lucía Mateo Sofia Emil Frieda Grace Hugo Ines Jakob Kofi Leila Miguel Noor Pierre Priya Ruth Sven Thandi Mr_Becker Mrs_Lopez
Dr_Singh Ms_Tanaka Mr_Dubois Mrs_Okafor Mr_Rossi Mrs_Novak Dr_Klein Mr_Sato Mrs_Haddad""".split()
# In German the stem, in French and Spanish the four forms (+ for an adjective before its noun), in Japanese what stands before the noun.
ADJECTIVES = {
    "red": ("rot", "rouge rouge rouges rouges", "rojo roja rojos rojas", "赤い"),
    "blue": ("blau", "bleu bleue bleus bleues", "azul azul azules azules", "青い"),
    "green": ("grün", "vert verte verts vertes", "verde verde verdes verdes", "緑の"),
    "yellow": ("gelb", "jaune jaune jaunes jaunes", "amarillo amarilla amarillos amarillas", "黄色い"),
    "white": ("weiß", "blanc blanche blancs blanches", "blanco blanca blancos blancas", "白い"),
    "black": ("schwarz", "noir noire noirs noires", "negro negra negros negras", "黒い"),
    "grey": ("grau", "gris grise gris grises", "gris gris grises grises", "灰色の"),
    "brown": ("braun", "marron marron marron marron", "marrón marrón marrones marrones", "茶色い"),
    "big": ("groß", "+grand grande grands grandes", "grande grande grandes grandes", "大きい"),
    "small": ("klein", "+petit petite petits petites", "pequeño pequeña pequeños pequeñas", "小さい"),
    "old": ("alt", "+vieux vieille vieux vieilles", "viejo vieja viejos viejas", "古い"),
    "new": ("neu", "+nouveau nouvelle nouveaux nouvelles", "nuevo nueva nuevos nuevas", "新しい"),
    "left": ("link", "de_gauche " * 4, "de_la_izquierda " * 4, "左の"),
    "right": ("recht", "de_droite " * 4, "de_la_derecha " * 4, "右の"),
    "front": ("vorder", "de_devant " * 4, "de_delante " * 4, "手前の"),
    "back": ("hinter", "de_derrière " * 4, "de_atrás " * 4, "奥の"),
}
# By unit: the least and the greatest number, and how it is said.
AMOUNTS = {
    "degC": (5, 95, ["{} degrees", "{} Grad", "{} degrés", "{} grados", "{}度"]),
    "percent": (5, 100, ["{} percent", "{} Prozent", "{} pour cent", "{} por ciento", "{}パーセント"]),
    "min": (2, 60, ["{} minutes", "{} Minuten", "{} minutes", "{} minutos", "{}分"]),
    "litre": (1, 20, ["{} litres", "{} Liter", "{} litres", "{} litros", "{}リットル"]),
    "lux": (50, 900, ["{} lux", "{} Lux", "{} lux", "{} lux", "{}ルクス"]),
    "": (1, 12, ["{}"] * 5),
}
PARAMETERS = {
    "thing": ["ITEM", "THING", "OBJECT"], "food": ["FOOD", "ITEM"], "plant": ["PLANT", "BED"], "animal": ["ANIMAL"],
    "person": ["PERSON", "GUEST", "WHO"], "device": ["DEVICE"], "container": ["CONTAINER", "BOX", "FURNITURE"],
    "furniture": ["FURNITURE", "SURFACE", "PLACE"], "place": ["PLACE", "ROOM", "AREA", "SPOT"], "door": ["DOOR", "OPENING"],
}
TASKS = [
    "You read what a person wants from a {robot} and say which goals it has to reach.",
    "You read what a person wants a robot to do in {place} and say which goals the robot has to reach.",
    "You turn what a person says to a {robot} into its goals.",
]
ADVICE = (
    'Join several goals with " & ". Say only what the person asks for, with the names of the lists.\n\n'
    "If the person asks for something that is not in the lists, says nothing that can be done, or only wants to know something, "
    "ask back instead: question: and one short question."
)
# Facts that no goal word is about, which some robots have.
STATES = ["robot_at(PLACE)", "robot_at(PLACE), holding(ITEM)", "held(THING)"]
ANCHOR = "- never GOAL until"
BUT = {"en": [", but ", ". But ", "; ", ", and "], "de": [", aber ", ". Aber ", "; ", ", und "], "fr": [", mais ", ". Mais ", " ; ", ", et "],
       "es": [", pero ", ". Pero ", "; ", ", y "], "ja": ["。ただし、", "。でも、", "。"]}
WITHOUT = {"en": "without", "de": "ohne", "fr": "sans", "es": "sin", "ja": "\0"}
ALSO = {"en": [" And ", ". ", ", and ", " Also: ", "; "], "de": [". Und ", ". ", ", und ", ". Außerdem: ", "; "],
        "fr": [". Et ", ". ", ", et ", " ; "], "es": [". Y ", ". ", ", y ", "; "], "ja": ["。それから", "。", "。あと、"]}
FIRST = {
    "en": [("First: ", " Then: "), ("", " After that: "), ("", " Then: "), ("Start with this: ", " When that is done: ")],
    "de": [("Zuerst: ", " Danach: "), ("", " Anschließend: "), ("", " Und dann: "), ("Erst mal: ", " Wenn das erledigt ist: ")],
    "fr": [("D'abord : ", " Ensuite : "), ("", " Après ça : "), ("", " Puis : ")],
    "es": [("Primero: ", " Después: "), ("", " Luego: "), ("", " Cuando acabes: ")],
    "ja": [("まず、", "その後、"), ("", "それが終わったら、"), ("", "次に、")],
}
LEAVE = {
    "en": ["leave {X} alone", "hands off {X}", "don't touch {X}", "{X} stays as it is"],
    "de": ["lass {X:acc} in Ruhe", "Finger weg von {X:dat}", "{X} bleibt, wie es ist", "fass {X:acc} nicht an"],
    "fr": ["ne touche pas {X:à}", "laisse {X} tranquille", "pas touche {X:à}"],
    "es": ["no toques {X}", "deja {X} en paz", "ni se te ocurra tocar {X}"],
    "ja": ["{X}には触らないで", "{X}はそのままにしておいて", "{X}はいじらないで"],
}
NO = {"en": ["No, {}", "Not that. {}", "I meant: {}", "No no. {}"], "de": ["Nein, {}", "Nicht das. {}", "Ich meinte: {}", "Falsch. {}"],
      "fr": ["Non, {}", "Pas ça. {}", "Je voulais dire : {}"], "es": ["No, {}", "Eso no. {}", "Quería decir: {}"],
      "ja": ["違う、{}", "そうじゃなくて、{}", "いや、{}"]}
AND = {"en": ["And {}", "Also: {}", "Oh, and {}", "{}"], "de": ["Und {}", "Außerdem: {}", "Ach ja: {}", "{}"],
       "fr": ["Et {}", "Aussi : {}", "Ah, et {}", "{}"], "es": ["Y {}", "También: {}", "Ah, y {}", "{}"], "ja": ["あと、{}", "それから{}", "{}"]}
AFTER = {"en": ["Afterwards: {}", "And then {}", "After that: {}"], "de": ["Danach: {}", "Und hinterher: {}", "Anschließend: {}"],
         "fr": ["Ensuite : {}", "Et après : {}", "Puis {}"], "es": ["Después: {}", "Y luego: {}", "Cuando termines: {}"],
         "ja": ["その後、{}", "終わったら、{}"]}
BEFORE = {"en": ["But first: {}", "Before that: {}", "Do this first: {}"], "de": ["Aber vorher: {}", "Zuerst noch: {}", "Davor: {}"],
          "fr": ["Mais d'abord : {}", "Avant ça : {}"], "es": ["Pero antes: {}", "Antes de eso: {}", "Primero: {}"],
          "ja": ["その前に、{}", "でもまず、{}"]}
DROP = {
    "en": ["Forget about {X}", "Leave {X} out of it", "Not {X} after all", "{X} is not necessary"],
    "de": ["Vergiss {X:acc}", "{X:acc} kannst du weglassen", "{X} doch nicht", "{X} ist nicht nötig"],
    "fr": ["Oublie {X}", "Finalement pas {X}", "{X}, ce n'est pas la peine"],
    "es": ["Olvida {X}", "{X} al final no", "{X} no hace falta"],
    "ja": ["{X}はやっぱりいい", "{X}はなしで", "{X}は要らない"],
}
CONTRACTIONS = [("in dem ", "im "), ("an dem ", "am "), ("zu dem ", "zum "), ("zu der ", "zur "), ("von dem ", "vom "), ("bei dem ", "beim "),
                ("in das ", "ins "), ("an das ", "ans ")]


def read_nouns():
    """The nouns by class: a name, and in each language the ways to call it."""
    nouns, known = collections.defaultdict(list), set()
    for path in sorted(glob.glob(str(FOLDER / "nouns-*.tsv"))):
        for line in open(path, encoding="utf-8"):
            name, kind, *columns = line.rstrip("\n").split("\t")
            ways = {language: [way.strip().replace("’", "'") for way in column.split("/") if way.strip()]
                    for language, column in zip(LANGUAGES, columns)}
            if name not in known and len(ways) == len(LANGUAGES) and all(ways.values()):
                known.add(name)
                nouns[kind].append({"name": name, "kind": kind, "ways": ways})
    return nouns


def read_words():
    words, known = [], set()
    for path in sorted(glob.glob(str(FOLDER / "words-*.toml"))):
        with open(path, "rb") as file:
            for word in tomllib.load(file)["word"]:
                if word["name"] not in known:
                    known.add(word["name"])
                    words.append(word)
    return words


def german(way, case, adjective):
    is_plural = way.startswith("pl:")
    article, _, noun = way.removeprefix("pl:").partition(" ")
    gender = "plural" if is_plural else {"der": "m", "die": "f", "das": "n"}.get(article, "f")
    articles = {"nom": "der die das die", "acc": "den die das die", "dat": "dem der dem den", "gen": "des der des der"}[case].split()
    if case == "dat" and is_plural and noun[-1] not in "ns":
        noun += "n"
    if case == "gen" and gender in ("m", "n") and " " not in noun:
        noun += "es" if noun[-1] in "szßxd" else "s"
    if adjective:
        is_short = (case == "nom" and not is_plural) or (case == "acc" and gender in ("f", "n"))
        noun = f"{ADJECTIVES[adjective][0]}{'e' if is_short else 'en'} {noun}"
    return f"{articles[['m', 'f', 'n', 'plural'].index(gender)]} {noun}"


def french(way, preposition, adjective):
    article, noun = ("l", way[2:]) if way.startswith("l'") else way.split(" ", 1)
    if adjective:
        forms = ADJECTIVES[adjective][1].split()
        form = forms[{"le": 0, "la": 1, "les": 2, "l": 0}[article]].lstrip("+").replace("_", " ")
        if forms[0].startswith("+"):
            noun, article = f"{form} {noun}", "le" if article == "l" else article
        else:
            noun = f"{noun} {form}"
    before = {"à": {"le": "au ", "la": "à la ", "les": "aux ", "l": "à l'"}, "de": {"le": "du ", "la": "de la ", "les": "des ", "l": "de l'"}}
    return before.get(preposition, {"le": "le ", "la": "la ", "les": "les ", "l": "l'"})[article] + noun


def spanish(way, preposition, adjective):
    article, noun = way.split(" ", 1)
    if adjective:
        noun += " " + ADJECTIVES[adjective][2].split()[["el", "la", "los", "las"].index(article)].replace("_", " ")
    contracted = {"a": "al ", "de": "del "}
    if preposition in contracted:
        return contracted[preposition] + noun if article == "el" else f"{preposition} {article} {noun}"
    return f"{article} {noun}"


def ended(text, chance):
    return text if text.rstrip()[-1:] in ".!?。！？…" else text + chance.choice([".", "", "."])


def bare(text):
    return text.rstrip(" .!。！?？")


def lowered(text, language):
    """A text within a sentence. German keeps its capitals: its first word may be a noun."""
    return text if language == "de" else text[:1].lower() + text[1:]


class Robot:
    """A robot with goals and one scene."""

    def __init__(self, number, seed, nouns, words, ending, chance):
        self.chance, self.all_nouns, self.all_words = chance, nouns, words
        self.name = f"synthetic-{seed}-{number}"
        self.words = self.draw_words()
        self.entities, self.by_kind, self.used = [], collections.defaultdict(list), set()
        self.draw_entities()
        self.system, self.lead = self.prompt(ending), self.scene()

    def draw_words(self):
        chance, count, words = self.chance, self.chance.randint(6, 12), []
        for word in chance.sample(self.all_words, len(self.all_words)):
            if len(words) >= count:
                break
            if word not in words:
                words.append(word)
                opposite = next((own for own in self.all_words if own["name"] == word.get("opposite")), None)
                # What can be opened can mostly be closed.
                if opposite and opposite not in words and chance.random() < 0.8:
                    words.append(opposite)
        chance.shuffle(words)
        return words

    def new_noun(self, kind):
        """A noun none of whose ways is in use; none if there is none at hand."""
        for _ in range(30):
            noun = self.chance.choice(self.all_nouns[kind])
            ways = {way.lower() for language in LANGUAGES for way in noun["ways"][language]} | {noun["name"]}
            if not ways & self.used:
                return noun, ways
        return None, set()

    def add(self, kind):
        chance = self.chance
        if kind == "person" and chance.random() < 0.5:
            person = chance.choice(PEOPLE).replace("_", " ")
            if person.lower() in self.used:
                return
            self.used.add(person.lower())
            own = [{"person": person, "name": person, "kind": kind}]
        else:
            noun, ways = self.new_noun(kind)
            if noun is None:
                return
            self.used |= ways
            own = [{"noun": noun, "adjective": None, "name": noun["name"], "kind": kind}]
            if kind != "person" and chance.random() < 0.16:
                count = chance.choice([1, 2])
                own = [{"noun": noun, "adjective": adjective, "name": f"{adjective} {noun['name']}", "kind": kind, "is_twin": count == 2}
                       for adjective in chance.sample(list(ADJECTIVES), count)]
        self.entities += own
        self.by_kind[kind] += own

    def draw_entities(self):
        needed = {kind for word in self.words for kind in word["takes"] if not kind.startswith("value")}
        for kind in sorted(needed):
            for _ in range(self.chance.randint(2, 5)):
                self.add(kind)
        for kind in self.chance.sample(sorted(self.all_nouns), 3):
            if kind not in needed:
                self.add(kind)
        self.chance.shuffle(self.entities)

    def prompt(self, ending):
        def shown(word):
            names = []
            for kind in word["takes"]:
                name = "AMOUNT" if kind.startswith("value") else self.chance.choice(PARAMETERS[kind])
                names.append(name if name not in names else name + "2")
            return f"- {word['name']}({', '.join(names)}): {word['means']}"

        chance, place = self.chance, self.chance.choice(self.all_nouns["place"])["name"]
        robot = chance.choice([f"robot in the {place}", "household robot", "robot", f"robot that works at the {place}"])
        task = chance.choice(TASKS).format(robot=robot, place=f"the {place}")
        goals = "\n".join(shown(word) for word in self.words)
        if chance.random() < 0.5:
            ending = ending.replace(ANCHOR, f"- behind never and always also: {chance.choice(STATES)}\n{ANCHOR}")
        return f"{task}\n\nA goal is one of these:\n{goals}\n\n{ADVICE}{ending}"

    def scene(self):
        chance = self.chance
        of_places = {"place", "furniture", "container", "door", "device"} | ({"person"} if chance.random() < 0.5 else set())
        spots = [entity for entity in self.entities if entity["kind"] in ("place", "furniture", "container")]
        usual = {"door": "opens", "container": "opens", "device": "switch", "furniture": "has a top"}
        property_of = {kind: chance.choice([kind, None, usual.get(kind, kind)]) for kind in self.all_nouns}
        objects, places = [], []
        for entity in self.entities:
            kind, states = entity["kind"], []
            if kind in of_places:
                states += [property_of[kind]] if property_of[kind] else []
                if kind in ("door", "container", "device") and chance.random() < 0.4:
                    states.append("on" if kind == "device" else "open")
                if kind == "place" and chance.random() < 0.1:
                    states.append("robot here")
            else:
                if spots and chance.random() < 0.85:
                    states.append(chance.choice(["at ", "on ", "in "]) + chance.choice(spots)["name"])
                if property_of[kind] and kind != "thing":
                    states.insert(chance.randint(0, len(states)), property_of[kind])
            line = f"- {entity['name']}: {', '.join(states)}\n" if states else f"- {entity['name']}\n"
            (places if kind in of_places else objects).append(line)
        return "Objects:\n" + "".join(objects) + "Places:\n" + "".join(places) + "\nInstruction:"

    def arguments(self, word):
        """An entity, or an amount, for each place of a word; none if there are too few."""
        arguments = []
        for kind in word["takes"]:
            if kind.startswith("value"):
                unit = kind.partition(":")[2]
                least, most, _ = AMOUNTS.get(unit, AMOUNTS[""])
                arguments.append({"amount": self.chance.randint(least, most), "unit": unit})
                continue
            others = [entity for entity in self.by_kind[kind] if entity not in arguments]
            if not others:
                return None
            arguments.append(self.chance.choice(others))
        return arguments

    def drawn(self):
        """A word with its arguments, and the goal that they make; none if there are too few entities."""
        word = self.chance.choice(self.words)
        arguments = self.arguments(word)
        return (word, arguments, written(word, arguments)) if arguments else None

    def render(self, entity, language, form, is_short):
        """An entity as it is said; `form` is a case or a preposition, and a short way has no adjective."""
        if "amount" in entity:
            return AMOUNTS.get(entity["unit"], AMOUNTS[""])[2][LANGUAGES.index(language)].format(entity["amount"])
        if "person" in entity:
            return self.render_person(entity["person"], language, form)
        adjective = None if is_short else entity["adjective"]
        ways = entity["noun"]["ways"][language]
        way = self.chance.choice(ways) if self.chance.random() < 0.55 else ways[0]
        if language == "en":
            return f"the {adjective} {way}" if adjective else f"the {way}"
        if language == "ja":
            return (ADJECTIVES[adjective][3] if adjective else "") + way
        return {"de": lambda: german(way, form or "nom", adjective), "fr": lambda: french(way, form, adjective),
                "es": lambda: spanish(way, form, adjective)}[language]()

    def render_person(self, name, language, form):
        if language == "fr":
            return {"à": f"à {name}", "de": ("d'" if name[0] in "AEIOUÉ" else "de ") + name}.get(form, name)
        if language == "es":
            return {"a": f"a {name}", "de": f"de {name}"}.get(form, name)
        if language == "ja":
            return name + self.chance.choice(["さん", "さん", ""])
        if language == "de":
            return name.replace("Mr ", "Herrn " if form in ("acc", "dat") else "Herr ").replace("Mrs ", "Frau ").replace("Ms ", "Frau ")
        return name

    def fill(self, frame, language, arguments, are_short):
        def own(match):
            place = 0 if match[1] == "X" else 1
            return self.render(arguments[place], language, match[3] or "", are_short[place])

        text = re.sub(r"\{([XY])(:(\w+|à))?\}", own, frame)
        if language == "de":
            for apart, together in CONTRACTIONS:
                if self.chance.random() < 0.9:
                    text = text.replace(f" {apart}", f" {together}")
                if text.lower().startswith(apart):
                    text = together.capitalize() + text[len(apart):]
        return text[:1].upper() + text[1:] if self.chance.random() < 0.85 else text[:1].lower() + text[1:]

    def short_ones(self, arguments):
        """Where one thing of a name is there, half of the time nobody says its colour."""
        return [bool(own.get("adjective")) and not own.get("is_twin") and self.chance.random() < 0.5 for own in arguments]

    def say(self, word, arguments, language):
        return self.fill(self.chance.choice(word[language]), language, arguments, self.short_ones(arguments))

    def forbid(self, word, arguments, language, alone=False):
        frames = word["not_" + language]
        if alone:
            frames = [own for own in frames if not own.lower().startswith(WITHOUT[language]) and not own.endswith(("ずに", "に"))]
        return self.fill(self.chance.choice(frames), language, arguments, self.short_ones(arguments)) if frames else None

    def untouched(self, entity, language):
        return self.fill(self.chance.choice(LEAVE[language]), language, [entity], self.short_ones([entity]))

    def case(self):
        """What is said, and the answer; and what was answered and said next. None for draws that make no case."""
        chance = self.chance
        language = chance.choices(LANGUAGES, SHARES)[0]
        own = self.drawn()
        if own is None:
            return None
        if chance.random() < 0.09:
            return self.conversation(language, *own)
        kinds = [(self.wish, 60), (self.two_wishes, 8), (self.wish_and_prohibition, 13), (self.prohibition, 5), (self.order, 6),
                 (self.which, 3), (self.missing, 3), (self.no_goal, 2)]
        make = chance.choices([kind for kind, _ in kinds], [share for _, share in kinds])[0]
        made = make(language, *own)
        return made and (*made, [])

    def wish(self, language, word, arguments, goal):
        return ended(self.say(word, arguments, language), self.chance), goal

    def two_wishes(self, language, word, arguments, goal):
        other = self.drawn()
        if other is None or other[2] == goal or other[0]["name"] == word.get("opposite"):
            return None
        joint, more = self.chance.choice(ALSO[language]), self.say(*other[:2], language)
        if joint.endswith(("and ", "und ", "et ", "y ")):
            more = lowered(more, language)
        return ended(bare(self.say(word, arguments, language)) + joint + more, self.chance), f"{goal} & {other[2]}"

    def wish_and_prohibition(self, language, word, arguments, goal):
        chance, other = self.chance, self.drawn()
        if other is None or other[2] == goal:
            return None
        if other[0]["name"] in (word["name"], word.get("opposite")) and other[1][0] == arguments[0]:
            return None
        if chance.random() < 0.25:
            left_alone = other[1][0]
            if "amount" in left_alone or left_alone in arguments:
                return None
            forbidden, constraint = self.untouched(left_alone, language), f"untouched({left_alone['name']})"
        else:
            forbidden, constraint = self.forbid(*other[:2], language), f"never {other[2]}"
        asked, inner = self.say(word, arguments, language), forbidden[:1].lower() + forbidden[1:]
        if inner.startswith(WITHOUT[language]):
            text = bare(asked) + chance.choice([", ", " ", ", "]) + inner
        elif language == "ja" and forbidden.endswith(("に", "ないで")) and chance.random() < 0.5:
            text = forbidden + ("、" if chance.random() < 0.7 else "") + asked
        else:
            joint = chance.choice(BUT[language])
            text = bare(asked) + joint + (inner if joint.startswith((",", ";", " ;")) else forbidden)
        return ended(text, chance), f"{goal} & {constraint}"

    def prohibition(self, language, word, arguments, goal):
        if self.chance.random() < 0.3:
            entity = arguments[0]
            if "amount" in entity:
                return None
            return ended(self.untouched(entity, language), self.chance), f"untouched({entity['name']})"
        text = self.forbid(word, arguments, language, alone=True)
        return (ended(text, self.chance), f"never {goal}") if text else None

    def order(self, language, word, arguments, goal):
        other = self.drawn()
        if other is None or other[2] == goal:
            return None
        before, between = self.chance.choice(FIRST[language])
        first, then = bare(self.say(word, arguments, language)), self.say(*other[:2], language)
        text = before + (lowered(first, language) if before else first) + ("。" if language == "ja" else ".") + between + lowered(then, language)
        return ended(text, self.chance), f"{goal} then {other[2]}"

    def which(self, language, word, arguments, goal):
        twins = [own for own in arguments if own.get("is_twin")]
        if not twins:
            return None
        return ended(self.fill(self.chance.choice(word[language]), language, arguments, [own is twins[0] for own in arguments]), self.chance), None

    def missing(self, language, word, arguments, goal):
        place = self.chance.randrange(len(arguments))
        if "noun" not in arguments[place]:
            return None
        noun, _ = self.new_noun(arguments[place]["kind"])
        if noun is None:
            return None
        arguments = list(arguments)
        arguments[place] = {"noun": noun, "adjective": None, "name": noun["name"], "kind": noun["kind"]}
        return ended(self.say(word, arguments, language), self.chance), None

    def no_goal(self, language, word, arguments, goal):
        other = self.chance.choice([own for own in self.all_words if own not in self.words])
        arguments = self.arguments(other)
        return (ended(self.say(other, arguments, language), self.chance), None) if arguments else None

    def conversation(self, language, word, arguments, goal):
        """An instruction, what was answered, what is said next, and the goal that is wanted then."""
        chance, other = self.chance, self.drawn()
        if other is None or other[2] == goal:
            return None
        says = ended(self.say(word, arguments, language), chance)
        more = lowered(bare(self.say(*other[:2], language)), language)
        kind = chance.choices(["which", "no", "and", "after", "before", "forbid", "less"], [22, 16, 12, 12, 8, 14, 16])[0]
        if kind == "which":
            twins = [own for own in arguments if own.get("is_twin")]
            if not twins:
                return None
            meant = twins[0]
            names = [own["name"] for own in self.entities if own.get("is_twin") and own["noun"] is meant["noun"]]
            chance.shuffle(names)
            says = ended(self.fill(chance.choice(word[language]), language, arguments, [own is meant for own in arguments]), chance)
            question = f"question: Which {meant['noun']['name'].split()[-1]} do you mean: {chance.choice([', or ', ' or ']).join(names)}?"
            answer = self.fill("{X:acc}" if language == "de" else "{X}", language, [meant], [False])
            return says, goal, [[question, ended(answer, chance)]]
        if kind == "no":
            place = chance.randrange(len(arguments))
            others = [own for own in self.by_kind[arguments[place].get("kind")] if own not in arguments]
            if not others:
                return None
            wrong = list(arguments)
            wrong[place] = chance.choice(others)
            again = lowered(bare(self.say(word, arguments, language)), language)
            return says, goal, [[written(word, wrong), ended(chance.choice(NO[language]).format(again), chance)]]
        for own, frames, wanted in [("and", AND, f"{goal} & {other[2]}"), ("after", AFTER, f"{goal} then {other[2]}"),
                                    ("before", BEFORE, f"{other[2]} then {goal}")]:
            if kind == own:
                return says, wanted, [[goal, ended(chance.choice(frames[language]).format(more), chance)]]
        if kind == "forbid":
            if other[0]["name"] in (word["name"], word.get("opposite")) and other[1][0] == arguments[0]:
                return None
            return says, f"{goal} & never {other[2]}", [[goal, ended(self.forbid(*other[:2], language), chance)]]
        dropped = other[1][0]
        if "amount" in dropped or dropped in arguments:
            return None
        both = [goal, other[2]] if chance.random() < 0.5 else [other[2], goal]
        joint = chance.choice([own for own in ALSO[language] if not own.endswith(("and ", "und ", "et ", "y "))])
        less = self.fill(chance.choice(DROP[language]), language, [dropped], self.short_ones([dropped]))
        return ended(bare(says) + joint + more, chance), goal, [[" & ".join(both), ended(less, chance)]]


def written(word, arguments):
    """A goal in the goal language."""
    names = [f"{own['amount']} {own['unit']}".strip() if "amount" in own else own["name"] for own in arguments]
    return f"{word['name']}({', '.join(names)})"


def main():
    reads = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    reads.add_argument("data")
    reads.add_argument("out")
    reads.add_argument("--robots", type=int, default=660)
    reads.add_argument("--cases", type=int, default=40, help="of each robot")
    reads.add_argument("--seed", type=int, default=100)
    read = reads.parse_args()
    chance = random.Random(read.seed)
    with open(read.data) as lines:
        system = json.loads(next(lines))["fixed"][0][1]
    ending = system[system.index("\n\nBeyond plain goals:"):]
    ending = re.sub(r"- behind never and always also: .*\n", "", ending)
    nouns, words = read_nouns(), read_words()
    made = 0
    with open(read.out, "w") as out:
        for number in range(read.robots):
            robot = Robot(number, read.seed, nouns, words, ending, chance)
            count = tries = 0
            while count < read.cases and tries < 5 * read.cases:
                tries += 1
                case = robot.case()
                if case is None:
                    continue
                says, answer, rounds = case
                rounds = [[reply, " ".join(message.split())] for reply, message in rounds]
                out.write(json.dumps({
                    "suite": robot.name, "id": f"{robot.name}-{count}", "fixed": [["system", robot.system]], "lead": robot.lead,
                    "instruction": " " + " ".join(says.split()), "rounds": rounds, "answer": answer,
                }, ensure_ascii=False) + "\n")
                count += 1
            made += count
    print(f"{sum(map(len, nouns.values()))} nouns, {len(words)} goal words, {made} cases of {read.robots} robots")


if __name__ == "__main__":
    main()
