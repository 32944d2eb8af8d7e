class StreakMaskBasisFunction: pass
