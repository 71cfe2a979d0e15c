// Exact 64-bit integers without a 64-bit extension: two's complement, high word signed.
// Results are those of C's int64_t with wrapping arithmetic. tests/gpu/int64.c compares them.

struct i64 {
	int hi;
	uint lo;
};

i64 i64_from(int v)
{
	return i64(v >> 31, uint(v));
}

i64 i64_add(i64 a, i64 b)
{
	uint carry;
	uint lo = uaddCarry(a.lo, b.lo, carry);
	return i64(int(uint(a.hi) + uint(b.hi) + carry), lo);
}

i64 i64_sub(i64 a, i64 b)
{
	uint borrow;
	uint lo = usubBorrow(a.lo, b.lo, borrow);
	return i64(int(uint(a.hi) - uint(b.hi) - borrow), lo);
}

i64 i64_neg(i64 a)
{
	return i64_sub(i64(0, 0u), a);
}

// 32 x 32 -> 64, signed.
i64 i64_mul(int a, int b)
{
	int hi, lo;
	imulExtended(a, b, hi, lo);
	return i64(hi, uint(lo));
}

// The low 64 bits of a 64 x 32 signed product.
i64 i64_mul_int(i64 a, int b)
{
	uint hi, lo;
	umulExtended(a.lo, uint(b), hi, lo);
	hi += uint(a.hi) * uint(b);
	if (b < 0)
		hi -= a.lo;
	return i64(int(hi), lo);
}

bool i64_less(i64 a, i64 b)
{
	return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo);
}

// Shifts choose rather than branch: branches on a uniform n, inlined many times over, are what
// LLVM 15's code generator for AVX-512 dies of.

// Arithmetic shift right, 0 <= n <= 63: the quotient by 2^n rounded down.
i64 i64_sar(i64 a, int n)
{
	int m = n & 31;
	int hi = a.hi >> m;
	uint lo = (a.lo >> m) | ((uint(a.hi) << 1) << (31 - m));
	bool whole = n >= 32;
	return i64(whole ? a.hi >> 31 : hi, whole ? uint(hi) : lo);
}

// 0 <= n <= 63; bits shifted out are lost.
i64 i64_shl(i64 a, int n)
{
	int m = n & 31;
	uint lo = a.lo << m;
	uint hi = (uint(a.hi) << m) | ((a.lo >> 1) >> (31 - m));
	bool whole = n >= 32;
	return i64(int(whole ? lo : hi), whole ? 0u : lo);
}

// Within two rounding errors of the value, for guesses only; the sign is exact.
float i64_to_float(i64 a)
{
	bool negative = a.hi < 0;
	if (negative)
		a = i64_neg(a);
	float magnitude = float(uint(a.hi)) * 4294967296.0 + float(a.lo);
	return negative ? -magnitude : magnitude;
}

// The low 32 bits.
int i64_to_int(i64 a)
{
	return int(a.lo);
}

i64 i64_min(i64 a, i64 b)
{
	return i64_less(a, b) ? a : b;
}

i64 i64_max(i64 a, i64 b)
{
	return i64_less(a, b) ? b : a;
}

i64 i64_clamp(i64 v, i64 low, i64 high)
{
	return i64_min(i64_max(v, low), high);
}
