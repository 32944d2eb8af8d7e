"""Writes src/plot/constellations.csv: the lines of constellations as chains of positions of stars.

    python tests/reference/make_constellations.py stars.6.json starnames.json > src/plot/constellations.csv

The lines are our own choice: chains of stars, given by their Bayer letters or Flamsteed numbers. Positions and
designations of the stars are in the npm package d3-celestial 0.7.35, folder data; its lines of constellations are not
used. Chains are separated by semicolons; a star of another constellation has the abbreviation of that constellation.
The name of a constellation is drawn in the middle of its first chain.
"""

import json
import sys

LINES = """
And Andromeda: α δ β γ; β μ ν; δ π; δ ε ζ
Aps Apus: α γ β
Aql Aquila: γ α β; α δ λ; ζ δ η θ
Aqr Aquarius: ε β α θ λ τ δ; α γ ζ η
Ara Ara: θ α β γ δ η ζ ε α
Ari Aries: 41 α β γ
Aur Auriga: α β θ Tau.β ι η ε α
Boo Boötes: α ε δ β γ ρ α; α η; α ζ
CMa Canis Major: β α δ η; δ ε
CMi Canis Minor: α β
CVn Canes Venatici: α β
Cam Camelopardalis: β α γ
Cap Capricornus: α β ψ ω ζ δ γ ι θ α
Car Carina: χ ε ι θ ω β α
Cas Cassiopeia: ε δ γ α β
Cen Centaurus: α β ε ζ μ ν θ; ν ι; ε γ δ
Cep Cepheus: α β γ ι ζ α; β ι
Cet Cetus: γ δ ζ θ η β τ ζ; η ι; α λ μ ξ2 γ α
Cha Chamaeleon: α γ β
Cir Circinus: β α γ
Cnc Cancer: ι γ δ α; δ β
Col Columba: ε α β γ δ; β η
Com Coma Berenices: α β γ
CrA Corona Australis: γ α β δ
CrB Corona Borealis: θ β α γ δ ε ι
Crt Crater: α β γ δ α; γ ζ η; δ ε θ
Cru Crux: α γ; β δ
Crv Corvus: γ δ β ε γ; ε α
Cyg Cygnus: α γ η β; ζ ε γ δ ι κ
Del Delphinus: ε β α γ δ β
Dor Dorado: γ α ζ β δ
Dra Draco: λ κ α ι θ η ζ χ δ ξ γ β ν ξ
Equ Equuleus: α δ γ
Eri Eridanus: β ω μ ν ο1 γ π δ ε η τ1 τ3 τ4 τ5 τ6 τ8 τ9 υ1 υ2 υ4 θ ι κ φ χ α
For Fornax: α β ν
Gem Gemini: α τ ε μ η; ε ν; τ ι υ β; υ δ ζ γ; δ λ ξ; υ κ
Gru Grus: γ λ δ1 β ε ζ; δ1 α β
Her Hercules: ε ζ η π ε δ α β ζ; β γ; π ρ θ ι; η σ τ φ; δ λ μ ξ ο
Hya Hydra: α υ1 λ μ ν ξ β γ π; ζ ε δ σ η ζ θ ι α
Hyi Hydrus: β γ α
Ind Indus: β α θ δ
Lac Lacerta: β α 4 5 2 6 1
Leo Leo: α η γ δ β θ α; γ ζ μ ε; θ δ
Lep Lepus: α β ε μ α ζ η; β γ δ α
Lib Libra: β α σ; β γ υ τ
LMi Leo Minor: 46 β 21
Lup Lupus: η γ δ β α ζ; γ ε
Lyn Lynx: α 38 31 21 15 2
Lyr Lyra: α ζ δ2 γ β ζ
Mon Monoceros: α ζ δ β γ; δ 18 13
Mus Musca: λ ε α β δ γ α
Oct Octans: β δ ν β
Oph Ophiuchus: α κ λ δ ε ζ η β α; η θ; β γ ν
Ori Orion: λ α ζ κ β δ γ λ; ζ ε δ; α γ π3; π1 π2 π3 π4 π5 π6; α μ ξ ν
Pav Pavo: α γ β δ α; β ε ζ; δ λ κ π η
Peg Pegasus: α β And.α γ α; α ξ ζ θ ε; β η; β μ λ ι κ
Per Perseus: η γ α δ ε ξ ζ ο; α κ β ρ
Phe Phoenix: ε α β ε; β γ δ ζ β
Pic Pictor: α γ β
PsA Piscis Austrinus: α ε μ ι β γ δ α
Psc Pisces: ω δ ε ζ μ ν ξ α ο π η ρ φ υ τ; κ γ θ ι λ κ; ι ω
Pup Puppis: ζ ρ ξ π ν τ σ ζ
Pyx Pyxis: β α γ
Ret Reticulum: α β δ ε α
Sco Scorpius: δ σ α τ ε μ1 ζ2 η θ ι1 κ λ υ; β δ π ρ
Scl Sculptor: α δ γ β
Sct Scutum: β α δ
Ser Serpens: β δ α ε μ; κ β γ κ; ν ξ η θ1
Sge Sagitta: γ δ α; δ β
Sgr Sagittarius: γ ε ζ τ σ φ λ δ γ; δ ε; φ ζ; λ μ; σ ο π; ε η
Tau Taurus: β ε δ γ θ2 α ζ; γ λ ξ ο
TrA Triangulum Australe: α β γ α
Tri Triangulum: α β γ α
Tuc Tucana: δ α γ β ζ
UMa Ursa Major: η ζ ε δ γ β α δ; γ χ ψ μ λ; χ ν ξ; β υ θ κ ι; α 23 ο; 23 υ
UMi Ursa Minor: α δ ε ζ η γ β ζ
Vel Vela: γ2 λ ψ μ φ κ δ γ2
Vir Virgo: β η γ θ α ζ δ γ; δ ε; ζ τ 109
Vol Volans: α β ε ζ γ2 δ ε α
Vul Vulpecula: 13 α
"""

places = {
    str(star["id"]): (star["geometry"]["coordinates"], star["properties"]["mag"])
    for star in json.load(open(sys.argv[1]))["features"]
}
stars = {}
for hip, names in json.load(open(sys.argv[2])).items():
    if hip not in places:
        continue
    bayer = names.get("bayer", "")
    # A letter without a number means the brightest of the stars with numbers.
    for designation in {bayer, bayer.rstrip("123456789"), names.get("flam", "")} - {""}:
        key = (names["c"], designation)
        if key not in stars or places[hip][1] < stars[key][1]:
            stars[key] = places[hip]

print("# name,chains: positions of stars, ICRS at epoch J2000, right ascension and declination in degrees, joined by lines")
print("# Origin: own choice of lines; positions of XHIP (V/137D), through d3-celestial 0.7.35; made by tests/reference/make_constellations.py")
for line in LINES.strip().splitlines():
    head, chains = line.split(":")
    constellation, name = head.split(" ", 1)
    written = []
    for chain in chains.split(";"):
        points = []
        for word in chain.split():
            of, designation = word.split(".") if "." in word else (constellation, word)
            if (of, designation) not in stars:
                sys.exit(f"{constellation}: no star {of} {designation}")
            (longitude_deg, dec_deg), _ = stars[of, designation]
            points.append(f"{longitude_deg % 360:.2f} {dec_deg:.2f}")
        written.append(" ".join(points))
    print(f"{name},{';'.join(written)}")
