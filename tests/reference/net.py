"""The net of `kernels.arithmetic.net` in whole numbers of Python: polynomials by long division, words as texts."""


def scrambled(x, key):
    """A reversed word after the nested scrambling by a key."""
    x ^= x * 0x3D20ADEA % 2**32
    x = (x + (key >> 32)) * (key % 2**32 | 1) % 2**32
    x ^= x * 0x05526C56 % 2**32
    return x ^ x * 0x53A22864 % 2**32


def turned_round(x):
    """The 32 bits of a word in the other order."""
    return int(f"{x:032b}"[::-1], 2)


def digits(v, base):
    """The digits of a polynomial over GF(2) to another one as its base, the lowest one first, by long division."""
    found, bits = 0, base.bit_length() - 1
    for k in range(0, 32, bits):
        quotient = 0
        while v.bit_length() > bits:
            shift = v.bit_length() - 1 - bits
            quotient, v = quotient | 1 << shift, v ^ base << shift
        found, v = found | v << k, quotient
    return found


def of_net(rank, keys):
    """The words of the three numbers of a rank."""
    low, high = rank % 2**32, rank >> 32
    index = turned_round(scrambled((turned_round(low) + high * 0x9E3779B9) % 2**32, keys[3]))
    for key, base in zip(keys, (0b10, 0b11, 0b111), strict=False):
        x = scrambled(digits(index, base), key)
        yield turned_round(x) << 32 | (x * 0x9E3779B9 ^ key) % 2**32
