"""The phrases of synthetic requests and conversations in five languages, and the parts of a robot's prompt."""

# The shares of the languages, in the order of `lexicon.LANGUAGES`.
LANGUAGE_WEIGHTS = [16, 22, 20, 20, 22]
# An underscore is a space within a name.
PEOPLE = """Anna Ben Carla David Elena Fatma Georg Hanna Ivan Julia Kenji Lena Marco Nadia Olga Pablo Quentin Rosa Samir Tomas Ursula Viktor Wanda Yuki
Zoe Ahmed Amélie Jonas Lucía Mateo Sofia Emil Frieda Grace Hugo Ines Jakob Kofi Leila Miguel Noor Pierre Priya Ruth Sven Thandi Mr_Becker Mrs_Lopez
Dr_Singh Ms_Tanaka Mr_Dubois Mrs_Okafor Mr_Rossi Mrs_Novak Dr_Klein Mr_Sato Mrs_Haddad""".split()
# By unit: the least and the greatest number, and its phrase in each language.
AMOUNTS = {
    "degC": (5, 95, ["{} degrees", "{} Grad", "{} degrés", "{} grados", "{}度"]),
    "percent": (5, 100, ["{} percent", "{} Prozent", "{} pour cent", "{} por ciento", "{}パーセント"]),
    "min": (2, 60, ["{} minutes", "{} Minuten", "{} minutes", "{} minutos", "{}分"]),
    "litre": (1, 20, ["{} litres", "{} Liter", "{} litres", "{} litros", "{}リットル"]),
    "lux": (50, 900, ["{} lux", "{} Lux", "{} lux", "{} lux", "{}ルクス"]),
    "": (1, 12, ["{}"] * 5),
}
# By class of an argument: the names of its parameter in the list of goals.
PARAMETER_NAMES = {
    "thing": ["ITEM", "THING", "OBJECT"],
    "food": ["FOOD", "ITEM"],
    "plant": ["PLANT", "BED"],
    "animal": ["ANIMAL"],
    "person": ["PERSON", "GUEST", "WHO"],
    "device": ["DEVICE"],
    "container": ["CONTAINER", "BOX", "FURNITURE"],
    "furniture": ["FURNITURE", "SURFACE", "PLACE"],
    "place": ["PLACE", "ROOM", "AREA", "SPOT"],
    "door": ["DOOR", "OPENING"],
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
# Facts that no goal word is about, which some robots have, and the line of the prompt that they precede.
EXTRA_FACTS = ["robot_at(PLACE)", "robot_at(PLACE), holding(ITEM)", "held(THING)"]
EXTRA_FACTS_ANCHOR = "- never GOAL until"
# Between a request and a prohibition.
BUT = {
    "en": [", but ", ". But ", "; ", ", and "],
    "de": [", aber ", ". Aber ", "; ", ", und "],
    "fr": [", mais ", ". Mais ", " ; ", ", et "],
    "es": [", pero ", ". Pero ", "; ", ", y "],
    "ja": ["。ただし、", "。でも、", "。"],
}
# A prohibition that begins with this word is a part of the sentence of the request. Japanese has none, and no text begins with "\0".
WITHOUT = {
    "en": "without",
    "de": "ohne",
    "fr": "sans",
    "es": "sin",
    "ja": "\0",
}
# Between two requests.
ALSO = {
    "en": [" And ", ". ", ", and ", " Also: ", "; "],
    "de": [". Und ", ". ", ", und ", ". Außerdem: ", "; "],
    "fr": [". Et ", ". ", ", et ", " ; "],
    "es": [". Y ", ". ", ", y ", "; "],
    "ja": ["。それから", "。", "。あと、"],
}
# Before the first and before the second of two ordered requests.
ORDERED = {
    "en": [("First: ", " Then: "), ("", " After that: "), ("", " Then: "), ("Start with this: ", " When that is done: ")],
    "de": [("Zuerst: ", " Danach: "), ("", " Anschließend: "), ("", " Und dann: "), ("Erst mal: ", " Wenn das erledigt ist: ")],
    "fr": [("D'abord : ", " Ensuite : "), ("", " Après ça : "), ("", " Puis : ")],
    "es": [("Primero: ", " Después: "), ("", " Luego: "), ("", " Cuando acabes: ")],
    "ja": [("まず、", "その後、"), ("", "それが終わったら、"), ("", "次に、")],
}
# Sentences that forbid touching an entity.
UNTOUCHED = {
    "en": ["leave {X} alone", "hands off {X}", "don't touch {X}", "{X} stays as it is"],
    "de": ["lass {X:acc} in Ruhe", "Finger weg von {X:dat}", "{X} bleibt, wie es ist", "fass {X:acc} nicht an"],
    "fr": ["ne touche pas {X:à}", "laisse {X} tranquille", "pas touche {X:à}"],
    "es": ["no toques {X}", "deja {X} en paz", "ni se te ocurra tocar {X}"],
    "ja": ["{X}には触らないで", "{X}はそのままにしておいて", "{X}はいじらないで"],
}
# The next message after an answer: a correction, a further request, a later one, an earlier one, one request less.
CORRECTION = {
    "en": ["No, {}", "Not that. {}", "I meant: {}", "No no. {}"],
    "de": ["Nein, {}", "Nicht das. {}", "Ich meinte: {}", "Falsch. {}"],
    "fr": ["Non, {}", "Pas ça. {}", "Je voulais dire : {}"],
    "es": ["No, {}", "Eso no. {}", "Quería decir: {}"],
    "ja": ["違う、{}", "そうじゃなくて、{}", "いや、{}"],
}
FURTHER = {
    "en": ["And {}", "Also: {}", "Oh, and {}", "{}"],
    "de": ["Und {}", "Außerdem: {}", "Ach ja: {}", "{}"],
    "fr": ["Et {}", "Aussi : {}", "Ah, et {}", "{}"],
    "es": ["Y {}", "También: {}", "Ah, y {}", "{}"],
    "ja": ["あと、{}", "それから{}", "{}"],
}
AFTER = {
    "en": ["Afterwards: {}", "And then {}", "After that: {}"],
    "de": ["Danach: {}", "Und hinterher: {}", "Anschließend: {}"],
    "fr": ["Ensuite : {}", "Et après : {}", "Puis {}"],
    "es": ["Después: {}", "Y luego: {}", "Cuando termines: {}"],
    "ja": ["その後、{}", "終わったら、{}"],
}
BEFORE = {
    "en": ["But first: {}", "Before that: {}", "Do this first: {}"],
    "de": ["Aber vorher: {}", "Zuerst noch: {}", "Davor: {}"],
    "fr": ["Mais d'abord : {}", "Avant ça : {}"],
    "es": ["Pero antes: {}", "Antes de eso: {}", "Primero: {}"],
    "ja": ["その前に、{}", "でもまず、{}"],
}
DROP = {
    "en": ["Forget about {X}", "Leave {X} out of it", "Not {X} after all", "{X} is not necessary"],
    "de": ["Vergiss {X:acc}", "{X:acc} kannst du weglassen", "{X} doch nicht", "{X} ist nicht nötig"],
    "fr": ["Oublie {X}", "Finalement pas {X}", "{X}, ce n'est pas la peine"],
    "es": ["Olvida {X}", "{X} al final no", "{X} no hace falta"],
    "ja": ["{X}はやっぱりいい", "{X}はなしで", "{X}は要らない"],
}
