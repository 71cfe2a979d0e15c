// A whole square root of 64 bits. Include lib/int64.glsl before it.

// floor(sqrt(d)), 0 <= d < 2^62: a guess in float, one correction, and steps of 1 to the exact root.
int square_root(i64 d)
{
	int q = int(sqrt(i64_to_float(d)));
	if (q > 0)
		q += int(floor(i64_to_float(i64_sub(d, i64_mul(q, q))) / (2.0 * float(q))));
	// rest is d - q * q. If q is the root, 0 <= rest <= 2 q.
	i64 rest = i64_sub(d, i64_mul(q, q));
	for (int k = 0; k < 3; k++) {
		bool over = rest.hi < 0;
		rest = i64_add(rest, i64_from_u(over ? 2u * uint(q) - 1u : 0u));
		q -= int(over);
	}
	for (int k = 0; k < 3; k++) {
		bool more = rest.hi > 0 || rest.lo > 2u * uint(q);
		rest = i64_sub(rest, i64_from_u(more ? 2u * uint(q) + 1u : 0u));
		q += int(more);
	}
	return q;
}
