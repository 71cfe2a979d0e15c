// A whole square root of 64 bits. Include lib/int64.glsl before it.

// floor(sqrt(d)), 0 <= d < 2^62. A guess in float is wrong by less than 2^12; after Newton's step it is wrong by 1 at most.
int square_root(i64 d)
{
	int q = int(sqrt(i64_to_float(d)));
	if (q > 0)
		q += int(floor(i64_to_float(i64_sub(d, i64_mul(q, q))) / (2.0 * float(q))));
	// q is now off by at most one. It is the root, rounded down, if the rest is from 0 to 2 q.
	i64 rest = i64_sub(d, i64_mul(q, q));
	bool over = rest.hi < 0, under = rest.hi > 0 || rest.lo > 2u * uint(q);
	return q + (over ? -1 : under ? 1 : 0);
}
