// What is found out about an object before it presses: of how many posts its patch is (PATCH), and how
// high it stands (LOAD). Try by try: what a try summed says where the next one looks, which every invocation of it
// works out for itself. Heights are fixed-point units above the prescribed.

struct attempt {
	int low, high;  // the soil carries it at low (or that is as deep as it may sink), and not at high
	int top, at;    // first contact; where this try looks
	uint gap;       // of try 0: the height of the first contact, + 2^31; 0: none
	uint posts;     // that are touched
	uint force[2];  // of the load, 2^-26
	uint stiff[2];  // growth of that per fixed-point unit, 2^-26
	uint done;      // it stands there
	uint spare;
};
layout(std430, binding = 2) restrict buffer attempts {
	attempt tries[];
};

float found_real(uint low, uint high)
{
	return float(high) * 4294967296.0 + float(low);
}

// Where try `k` looks, from the one before it; 0: as prescribed.
attempt found_next(int k, int depth)
{
	attempt b = tries[max(k - 1, 0)];
	attempt a;
	// The first is the guess, if that is in the ground.
	int top = k <= 1 ? int(b.gap ^ 0x80000000u) : b.top;
	float share = found_real(b.force[0], b.force[1]) * exp2(-26.0), grows = found_real(b.stiff[0], b.stiff[1]) * exp2(-26.0);
	bool carries = share >= 1.0;
	int low = k <= 1 ? top - depth : carries ? b.at : b.low, high = k <= 1 ? top : carries ? b.high : b.at;
	// Force is about a power of depth: Newton's step between logarithms.
	float z = float(top - b.at), power = clamp(z * grows / max(share, 1e-6), 0.1, 1e6);
	float step = z * exp2(clamp(-log2(max(share, 1e-6)) / power, -20.0, 20.0));
	int next = top - int(round(min(step, float(depth))));
	// Halved where the bracket lags, so that the last try leaves a fixed-point unit of it.
	int width = high - low;
	bool lags = width > (depth >> clamp(k - 6, 0, 31)) || share <= 1e-6;
	next = lags ? low + width / 2 : next;
	next = clamp(k <= 1 ? 0 : next, low + 1, max(high - 1, low + 1));
	bool there = k > 1 && abs(share - 1.0) < 2e-6;
	bool none = k <= 1 ? b.gap == 0u : b.done != 0u; // no ground below it, or found before
	a.top = top;
	a.low = low;
	a.high = high;
	a.at = k == 0 ? 0 : none || there ? (k <= 1 ? 0 : b.at) : width <= 1 ? low : next;
	a.done = uint(none || there || width <= 1);
	return a;
}

// 1 / b, of so many posts of this area; of one at least: what is only brushed counts too.
float found_by_width(uint posts, float area)
{
	return inversesqrt(max(float(posts), 1.0) * area * 0.31830989);
}
