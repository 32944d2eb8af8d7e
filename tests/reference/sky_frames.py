"""Frames for the reference scripts: TEME, GCRS, site, and directions as in a star-calibrated image.

Independent of streakcast: c2t06a and gmst82 of ERFA, astropy's reader of finals2000A, and the Earth's velocity from JPL
DE421. Nothing is downloaded; the data folder is STREAKCAST_DATA.
"""

import os
from pathlib import Path

import erfa
import numpy as np
from astropy.utils import iers
from jplephem.spk import SPK

iers.conf.auto_download = False
DATA = Path(os.environ.get("STREAKCAST_DATA") or Path(__file__).resolve().parents[3] / "shared/data")
SPEED_OF_LIGHT_KM_S = 299_792.458
DAY_S = 86_400.0

# Cerro Pachon (Rubin Observatory), WGS84.
LATITUDE_DEG, LONGITUDE_DEG, HEIGHT_M = -30.244639, -70.749417, 2663.0


def utc_to_jd(text):
    """Returns the two-part UTC Julian date of `YYYY-MM-DDTHH:MM:SS.sssZ` (midnight, fraction of the day).

    Not valid on days with a leap second.
    """
    date, time = text.rstrip("Z").split("T")
    year, month, day = map(int, date.split("-"))
    hour, minute, second = time.split(":")
    jd0, jd1 = erfa.cal2jd(year, month, day)
    return jd0 + jd1, (int(hour) * 3600 + int(minute) * 60 + float(second)) / DAY_S


def jd_to_utc(jd, fraction):
    """Returns a Julian date as text with milliseconds."""
    milliseconds = round(fraction * DAY_S * 1000)
    jd, milliseconds = jd + milliseconds // 86_400_000, milliseconds % 86_400_000
    year, month, day, _ = erfa.jd2cal(jd, 0.0)
    second, millisecond = divmod(milliseconds, 1000)
    return f"{year:04d}-{month:02d}-{day:02d}T{second // 3600:02d}:{second // 60 % 60:02d}:{second % 60:02d}.{millisecond:03d}Z"


class Frames:
    """Earth orientation from `aux/finals2000A.all` and the Earth's barycentric velocity from `aux/de421.bsp`."""

    def __init__(self):
        self.table = iers.IERS_A.open(str(DATA / "aux/finals2000A.all"))
        self.kernel = SPK.open(str(DATA / "aux/de421.bsp"))
        longitude, latitude = np.radians([LONGITUDE_DEG, LATITUDE_DEG])
        self.site_itrs_km = erfa.gd2gc(1, longitude, latitude, HEIGHT_M) / 1000.0
        self.up_itrs = np.array(
            [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
        )

    def at(self, jd, fraction):
        """Returns teme_to_gcrs and itrs_to_gcrs (n, 3, 3), and the Earth's velocity (n, 3) in km/s, for UTC dates."""
        fraction = np.atleast_1d(fraction)
        jd = np.broadcast_to(jd, fraction.shape)
        ut1_minus_utc = self.table.ut1_utc(jd, fraction).to_value("s")
        xp, yp = (x.to_value("rad") for x in self.table.pm_xy(jd, fraction))
        tai = erfa.utctai(jd, fraction)
        tt = erfa.taitt(*tai)
        ut1 = erfa.utcut1(jd, fraction, ut1_minus_utc)
        gcrs_to_itrs = erfa.c2t06a(*tt, *ut1, xp, yp)
        # TEME -> PEF by GMST82, PEF -> ITRS by polar motion (Vallado 2013, section 3.7.3; no TIO locator).
        gmst = erfa.gmst82(*ut1)
        teme_to_pef = erfa.rz(gmst, np.broadcast_to(np.eye(3), (*fraction.shape, 3, 3)))
        pef_to_itrs = erfa.pom00(xp, yp, 0.0)
        itrs_to_gcrs = np.swapaxes(gcrs_to_itrs, -1, -2)
        teme_to_gcrs = itrs_to_gcrs @ pef_to_itrs @ teme_to_pef
        # TT is used instead of TDB: 2 ms at an acceleration of 0.006 m/s² are negligible.
        _, emb = self.kernel[0, 3].compute_and_differentiate(tt[0], tt[1])
        _, earth = self.kernel[3, 399].compute_and_differentiate(tt[0], tt[1])
        return teme_to_gcrs, itrs_to_gcrs, (emb + earth).T / DAY_S

    def site(self, itrs_to_gcrs):
        """Returns site and zenith in GCRS (km, unit vector)."""
        return itrs_to_gcrs @ self.site_itrs_km, itrs_to_gcrs @ self.up_itrs


def astrometric(satellite_km, satellite_km_s, site_km, earth_km_s):
    """Returns the ICRS astrometric vector, km: r = r_sat - r_site - (v_sat + v_Earth) tau, all GCRS at reception.

    The Earth's aberration of 20 arcsec is *subtracted*, as in a plate solution.
    """
    geometric = satellite_km - site_km
    tau = np.linalg.norm(geometric, axis=-1, keepdims=True) / SPEED_OF_LIGHT_KM_S
    return geometric - (satellite_km_s + earth_km_s) * tau


def unit(vector):
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def separation(a, b):
    """Returns the angle between unit vectors, radians, accurate also for small angles."""
    return 2.0 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=-1) / 2.0, 1.0))


def radec_to_vector(ra_deg, dec_deg):
    ra, dec = np.radians(ra_deg), np.radians(dec_deg)
    return np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])


def vector_to_radec(vector):
    return np.degrees(np.arctan2(vector[1], vector[0])) % 360.0, np.degrees(np.arctan2(vector[2], np.hypot(vector[0], vector[1])))
