"""Inflects noun phrases in German, French and Spanish."""

from typing import NamedTuple


class Adjective(NamedTuple):
    """An adjective: the German stem, the French and Spanish forms (m, f, m plural, f plural), and the Japanese word before its noun.

    A French adjective that stands before its noun begins with `+`. An underscore is a space within a form.
    """

    german: str
    french: str
    spanish: str
    japanese: str


ADJECTIVES = {
    "red": Adjective("rot", "rouge rouge rouges rouges", "rojo roja rojos rojas", "赤い"),
    "blue": Adjective("blau", "bleu bleue bleus bleues", "azul azul azules azules", "青い"),
    "green": Adjective("grün", "vert verte verts vertes", "verde verde verdes verdes", "緑の"),
    "yellow": Adjective("gelb", "jaune jaune jaunes jaunes", "amarillo amarilla amarillos amarillas", "黄色い"),
    "white": Adjective("weiß", "blanc blanche blancs blanches", "blanco blanca blancos blancas", "白い"),
    "black": Adjective("schwarz", "noir noire noirs noires", "negro negra negros negras", "黒い"),
    "grey": Adjective("grau", "gris grise gris grises", "gris gris grises grises", "灰色の"),
    "brown": Adjective("braun", "marron marron marron marron", "marrón marrón marrones marrones", "茶色い"),
    "big": Adjective("groß", "+grand grande grands grandes", "grande grande grandes grandes", "大きい"),
    "small": Adjective("klein", "+petit petite petits petites", "pequeño pequeña pequeños pequeñas", "小さい"),
    "old": Adjective("alt", "+vieux vieille vieux vieilles", "viejo vieja viejos viejas", "古い"),
    "new": Adjective("neu", "+nouveau nouvelle nouveaux nouvelles", "nuevo nueva nuevos nuevas", "新しい"),
    "left": Adjective("link", "de_gauche " * 4, "de_la_izquierda " * 4, "左の"),
    "right": Adjective("recht", "de_droite " * 4, "de_la_derecha " * 4, "右の"),
    "front": Adjective("vorder", "de_devant " * 4, "de_delante " * 4, "手前の"),
    "back": Adjective("hinter", "de_derrière " * 4, "de_atrás " * 4, "奥の"),
}
# By case: masculine, feminine, neuter, plural.
GERMAN_ARTICLES = {"nom": "der die das die", "acc": "den die das die", "dat": "dem der dem den", "gen": "des der des der"}
GERMAN_CONTRACTIONS = [
    ("in dem ", "im "), ("an dem ", "am "), ("zu dem ", "zum "), ("zu der ", "zur "), ("von dem ", "vom "), ("bei dem ", "beim "),
    ("in das ", "ins "), ("an das ", "ans "),
]
# By preposition, else without one; `l` is the elided article.
FRENCH_ARTICLES = {
    "à": {"le": "au ", "la": "à la ", "les": "aux ", "l": "à l'"},
    "de": {"le": "du ", "la": "de la ", "les": "des ", "l": "de l'"},
    "": {"le": "le ", "la": "la ", "les": "les ", "l": "l'"},
}
SPANISH_CONTRACTIONS = {"a": "al ", "de": "del "}


def german(synonym: str, case: str, adjective: str | None) -> str:
    """Returns a German noun phrase with its definite article in a case (`nom`, `acc`, `dat`, `gen`)."""
    is_plural = synonym.startswith("pl:")
    article, _, noun = synonym.removeprefix("pl:").partition(" ")
    gender = "plural" if is_plural else {"der": "m", "die": "f", "das": "n"}.get(article, "f")
    if case == "dat" and is_plural and noun[-1] not in "ns":
        noun += "n"
    if case == "gen" and gender in ("m", "n") and " " not in noun:
        noun += "es" if noun[-1] in "szßxd" else "s"
    if adjective:
        has_ending_e = (case == "nom" and not is_plural) or (case == "acc" and gender in ("f", "n"))
        noun = f"{ADJECTIVES[adjective].german}{'e' if has_ending_e else 'en'} {noun}"
    articles = GERMAN_ARTICLES[case].split()
    return f"{articles[['m', 'f', 'n', 'plural'].index(gender)]} {noun}"


def french(synonym: str, preposition: str, adjective: str | None) -> str:
    """Returns a French noun phrase with its definite article, contracted with the preposition `à` or `de`."""
    article, noun = ("l", synonym[2:]) if synonym.startswith("l'") else synonym.split(" ", 1)
    if adjective:
        forms = ADJECTIVES[adjective].french.split()
        form = forms[{"le": 0, "la": 1, "les": 2, "l": 0}[article]].lstrip("+").replace("_", " ")
        if forms[0].startswith("+"):
            noun, article = f"{form} {noun}", "le" if article == "l" else article
        else:
            noun = f"{noun} {form}"
    return FRENCH_ARTICLES.get(preposition, FRENCH_ARTICLES[""])[article] + noun


def spanish(synonym: str, preposition: str, adjective: str | None) -> str:
    """Returns a Spanish noun phrase with its definite article, contracted with the preposition `a` or `de`."""
    article, noun = synonym.split(" ", 1)
    if adjective:
        forms = ADJECTIVES[adjective].spanish.split()
        noun += " " + forms[["el", "la", "los", "las"].index(article)].replace("_", " ")
    if preposition not in SPANISH_CONTRACTIONS:
        return f"{article} {noun}"
    return SPANISH_CONTRACTIONS[preposition] + noun if article == "el" else f"{preposition} {article} {noun}"
