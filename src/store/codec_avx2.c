/*
 * The codec's inner loops for x86-64 with AVX2, and the choice between them and the plain ones.
 *
 * Eight residuals of w bits are w bytes. Each half of a register loads 16 bytes, which hold four residuals; the second half
 * begins at bit 4 w. A shuffle moves the four bytes around each residual into its lane. A shift and a mask then cut it out.
 * This works up to 25 bits (7 + 25 = 32). Only lossless floats have wider blocks, and plain C decodes them.
 */
#include "store/codec_kernels.h"

#if defined(__x86_64__)

#include <immintrin.h>
#include <string.h>

#define WIDTH_MOST 25
#define LEVEL_NARROW 16
#define AVX2 __attribute__((target("avx2")))

/* Lane l, residual l of 8: `bit` is where it begins in its half. */
struct unpack {
	__m256i shuffle, shift, mask;
};

AVX2 static struct unpack plan_of(unsigned width)
{
	_Alignas(32) uint8_t shuffle[32];
	_Alignas(32) uint32_t shift[8];
	for (unsigned lane = 0; lane < 8; lane++) {
		unsigned bit = lane < 4 ? lane * width : lane * width - width / 2 * 8;
		for (unsigned byte = 0; byte < 4; byte++) {
			unsigned at = bit / 8 + byte; /* beyond the half: never part of the residual */
			shuffle[4 * lane + byte] = (uint8_t)(at < 16 ? at : 0x80);
		}
		shift[lane] = bit % 8;
	}
	return (struct unpack){
		_mm256_load_si256((const __m256i *)shuffle),
		_mm256_load_si256((const __m256i *)shift),
		_mm256_set1_epi32((int)((1u << width) - 1)),
	};
}

AVX2 static inline __m256i unpack8(const uint8_t *from, unsigned width, const struct unpack *plan)
{
	__m128i low = _mm_loadu_si128((const __m128i *)(const void *)from);
	__m128i high = _mm_loadu_si128((const __m128i *)(const void *)(from + width / 2));
	__m256i z = _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1);
	z = _mm256_and_si256(_mm256_srlv_epi32(_mm256_shuffle_epi8(z, plan->shuffle), plan->shift), plan->mask);
	__m256i sign = _mm256_sub_epi32(_mm256_setzero_si256(), _mm256_and_si256(z, _mm256_set1_epi32(1)));
	return _mm256_xor_si256(_mm256_srli_epi32(z, 1), sign);
}

AVX2 static const uint8_t *avx2_unpack(const uint8_t *from, const uint8_t *widths, size_t count, uint32_t *rest)
{
	struct unpack plans[WIDTH_MOST + 1];
	uint32_t planned = 0;
	for (size_t block = 0; block < count; block++, rest += CODEC_BLOCK) {
		unsigned width = widths[block];
		if (width > WIDTH_MOST) {
			store_codec_plain.unpack(from, widths + block, 1, rest);
		} else {
			if ((planned >> width & 1) == 0) {
				plans[width] = plan_of(width);
				planned |= 1u << width;
			}
			_mm256_storeu_si256((__m256i *)(void *)rest, unpack8(from, width, &plans[width]));
			_mm256_storeu_si256((__m256i *)(void *)(rest + 8),
					    unpack8(from + width, width, &plans[width]));
		}
		from += (size_t)2 * width;
	}
	return from;
}

/* Running sums of eight lanes. */
AVX2 static inline __m256i scan8(__m256i v)
{
	v = _mm256_add_epi32(v, _mm256_slli_si256(v, 4));
	v = _mm256_add_epi32(v, _mm256_slli_si256(v, 8));
	/* The lower half's last sum, to all of the upper half. */
	__m256i low = _mm256_permute2x128_si256(v, v, 0x08);
	return _mm256_add_epi32(v, _mm256_shuffle_epi32(low, 0xff));
}

AVX2 static inline __m256i last_of(__m256i v)
{
	return _mm256_permutevar8x32_epi32(v, _mm256_set1_epi32(7));
}

/* After a row's first post its posts are a whole number of eights: cells are a power of two from 8. */
AVX2 static void sum_row(const uint32_t *r, const int32_t *before, uint32_t side, bool slope, int32_t *row)
{
	__m256i sum = _mm256_set1_epi32((int)r[0]), step = _mm256_setzero_si256();
	row[0] = (int32_t)(r[0] + (uint32_t)before[0]);
	for (uint32_t x = 1; x < side; x += 8) {
		__m256i v = scan8(_mm256_loadu_si256((const __m256i *)(const void *)(r + x)));
		if (slope) {
			__m256i steps = _mm256_add_epi32(v, step);
			step = _mm256_add_epi32(step, last_of(v));
			v = scan8(steps);
		}
		__m256i posts = _mm256_add_epi32(v, sum);
		sum = _mm256_add_epi32(sum, last_of(v));
		posts = _mm256_add_epi32(posts, _mm256_loadu_si256((const __m256i *)(const void *)(before + x)));
		_mm256_storeu_si256((__m256i *)(void *)(row + x), posts);
	}
}

AVX2 static void avx2_sum(const uint32_t *rest, uint32_t side, uint32_t rows, const int32_t *before, bool slope,
			  int32_t *posts)
{
	for (uint32_t y = 0; y < rows; y++, rest += side, before = posts, posts += side)
		sum_row(rest, before, side, slope, posts);
}

/* --- levels --- */

/* Where the eight residuals of a width lie, known when this is compiled. Up to 16 bits all lie in 16 bytes, and both halves of a
 * register load these. `left` moves a residual's highest bit to that of its lane. */
struct level_plan {
	_Alignas(64) uint8_t shuffle[32];
	uint32_t left[8];
};

#define BIT(w, l) ((w) <= LEVEL_NARROW || (l) < 4 ? (l) * (w) : (l) * (w) - (w) / 2 * 8)
#define BYTE(w, l, b) (BIT(w, l) / 8 + (b) < 16 ? BIT(w, l) / 8 + (b) : 0x80)
#define LANE(w, l) BYTE(w, l, 0), BYTE(w, l, 1), BYTE(w, l, 2), BYTE(w, l, 3)
#define LEFT(w, l) 32 - (w) - BIT(w, l) % 8
#define EIGHT(of, w) of(w, 0), of(w, 1), of(w, 2), of(w, 3), of(w, 4), of(w, 5), of(w, 6), of(w, 7)
#define LEVEL_PLAN(w) {{EIGHT(LANE, w)}, {EIGHT(LEFT, w)}}
#define LEVEL_PLANS(w) LEVEL_PLAN(w), LEVEL_PLAN(w + 1), LEVEL_PLAN(w + 2), LEVEL_PLAN(w + 3), LEVEL_PLAN(w + 4)

static const struct level_plan level_plans[WIDTH_MOST + 1] = {
	LEVEL_PLAN(0), LEVEL_PLANS(1), LEVEL_PLANS(6), LEVEL_PLANS(11), LEVEL_PLANS(16), LEVEL_PLANS(21),
};

/* Cuts residuals out of bytes of which each half has its own, and gives them their sign. */
AVX2 static inline __attribute__((always_inline)) __m256i cut_level(__m256i bytes, unsigned width)
{
	const struct level_plan *plan = &level_plans[width];
	bytes = _mm256_shuffle_epi8(bytes, _mm256_load_si256((const __m256i *)(const void *)plan->shuffle));
	bytes = _mm256_sllv_epi32(bytes, _mm256_load_si256((const __m256i *)(const void *)plan->left));
	return _mm256_sra_epi32(bytes, _mm_cvtsi32_si128((int)(32 - width)));
}

/* More than LEVEL_NARROW bits. */
AVX2 static __attribute__((noinline)) __m256i unpack_wide(const uint8_t *from, unsigned width)
{
	if (width <= WIDTH_MOST) {
		__m128i low = _mm_loadu_si128((const __m128i *)(const void *)from);
		__m128i high = _mm_loadu_si128((const __m128i *)(const void *)(from + width / 2));
		return cut_level(_mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1), width);
	}
	_Alignas(32) int32_t rest[8];
	for (unsigned i = 0; i < 8; i++) {
		uint64_t bits;
		memcpy(&bits, from + i * width / 8, sizeof bits);
		rest[i] = (int32_t)((uint32_t)(bits >> i * width % 8) << (32 - width)) >> (32 - width);
	}
	return _mm256_load_si256((const __m256i *)(const void *)rest);
}

AVX2 static inline __attribute__((always_inline)) __m256i unpack_level(const uint8_t *from, unsigned width)
{
	if (__builtin_expect(width > LEVEL_NARROW, 0))
		return unpack_wide(from, width);
	return cut_level(_mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i *)(const void *)from)), width);
}

AVX2 static inline __m256i load8(const int32_t *from)
{
	return _mm256_loadu_si256((const __m256i *)(const void *)from);
}

/* level_between() of eight posts. */
AVX2 static inline __attribute__((always_inline)) __m256i between8(__m256i l, __m256i a, __m256i b, __m256i r, bool cubic)
{
	__m256i sum = _mm256_add_epi32(a, b);
	if (!cubic)
		return _mm256_srai_epi32(_mm256_sub_epi32(sum, _mm256_set1_epi32(-1)), 1);
	__m256i nine = _mm256_add_epi32(_mm256_slli_epi32(sum, 3), sum), two = _mm256_add_epi32(l, r);
	return _mm256_srai_epi32(_mm256_add_epi32(_mm256_sub_epi32(nine, two), _mm256_set1_epi32(8)), 4);
}

AVX2 static inline __attribute__((always_inline)) const uint8_t *spread(const int32_t *coarse, const uint8_t *from, const uint8_t *widths,
									size_t blocks, bool cubic, int32_t *row)
{
	for (size_t block = 0; block < blocks; block++, coarse += 8, row += 16) {
		__m256i even = load8(coarse), next = load8(coarse + 1);
		__m256i guess = cubic ? between8(load8(coarse - 1), even, next, load8(coarse + 2), true)
				      : between8(even, even, next, next, false);
		__m256i odd = _mm256_add_epi32(guess, unpack_level(from, widths[block]));
		__m256i low = _mm256_unpacklo_epi32(even, odd), high = _mm256_unpackhi_epi32(even, odd);
		_mm256_storeu_si256((__m256i *)(void *)row, _mm256_permute2x128_si256(low, high, 0x20));
		_mm256_storeu_si256((__m256i *)(void *)(row + 8), _mm256_permute2x128_si256(low, high, 0x31));
		from += widths[block];
	}
	row[0] = coarse[0];
	return from;
}

AVX2 static const uint8_t *avx2_spread(const int32_t *coarse, const uint8_t *from, const uint8_t *widths, size_t blocks, bool cubic,
				       int32_t *row)
{
	return cubic ? spread(coarse, from, widths, blocks, true, row) : spread(coarse, from, widths, blocks, false, row);
}

AVX2 static size_t avx2_total(const uint8_t *widths, size_t count, uint8_t *most)
{
	__m256i sums = _mm256_setzero_si256(), greatest = sums;
	for (; count >= 32; count -= 32, widths += 32) {
		__m256i some = _mm256_loadu_si256((const __m256i *)(const void *)widths);
		sums = _mm256_add_epi64(sums, _mm256_sad_epu8(some, _mm256_setzero_si256()));
		greatest = _mm256_max_epu8(greatest, some);
	}
	_Alignas(32) uint64_t four[4];
	_Alignas(32) uint8_t bytes[32];
	_mm256_store_si256((__m256i *)(void *)four, sums);
	_mm256_store_si256((__m256i *)(void *)bytes, greatest);
	size_t sum = four[0] + four[1] + four[2] + four[3];
	*most = 0;
	for (int i = 0; i < 32; i++)
		*most = bytes[i] > *most ? bytes[i] : *most;
	for (; count > 0; count--, widths++) {
		sum += *widths;
		*most = *widths > *most ? *widths : *most;
	}
	return sum;
}

AVX2 static inline size_t sum_of(const uint8_t *widths, size_t count)
{
	__m128i sums = _mm_setzero_si128();
	for (; count >= 16; count -= 16, widths += 16)
		sums = _mm_add_epi64(sums, _mm_sad_epu8(_mm_loadu_si128((const __m128i *)(const void *)widths), _mm_setzero_si128()));
	size_t sum = (size_t)_mm_cvtsi128_si64(sums) + (size_t)_mm_extract_epi64(sums, 1);
	for (; count > 0; count--)
		sum += *widths++;
	return sum;
}

AVX2 static inline __attribute__((always_inline)) void store8(int32_t *to, __m256i posts)
{
	_mm256_storeu_si256((__m256i *)(void *)to, posts);
}

/* Both rows at once, since they have three of four even rows in common. */
AVX2 static inline __attribute__((always_inline)) const uint8_t *between(int32_t *first, size_t stride, const int32_t *before,
									 const int32_t *after, const uint8_t *from,
									 const uint8_t *widths, size_t blocks, bool cubic)
{
	const uint8_t *second = from + sum_of(widths, blocks), *end = widths + blocks;
	const ptrdiff_t to_before = before - first, to_after = after - first;
	for (; widths < end; widths++, first += 8) {
		const unsigned width = widths[0], other = widths[blocks];
		__m256i b = load8(first), c = load8(first + 2 * stride), d = load8(first + 4 * stride);
		__m256i guess = between8(cubic ? load8(first + to_before) : b, b, c, d, cubic);
		__m256i next = between8(b, c, d, cubic ? load8(first + to_after) : d, cubic);
		store8(first + stride, _mm256_add_epi32(guess, unpack_level(from, width)));
		store8(first + 3 * stride, _mm256_add_epi32(next, unpack_level(second, other)));
		from += width;
		second += other;
	}
	return second;
}

AVX2 static const uint8_t *avx2_between(int32_t *first, size_t stride, const int32_t *before, const int32_t *after, const uint8_t *from,
					const uint8_t *widths, size_t blocks, bool cubic)
{
	return cubic ? between(first, stride, before, after, from, widths, blocks, true)
		     : between(first, stride, before, after, from, widths, blocks, false);
}

AVX2 static const uint8_t *avx2_level(const uint8_t *from, const uint8_t *widths, size_t blocks, int32_t *rest)
{
	for (size_t block = 0; block < blocks; block++, rest += 8) {
		_mm256_storeu_si256((__m256i *)(void *)rest, unpack_level(from, widths[block]));
		from += widths[block];
	}
	return from;
}

static const struct codec_kernels codec_avx2 = {"avx2", avx2_unpack, avx2_sum, avx2_spread, avx2_between, avx2_level, avx2_total};

const struct codec_kernels *store_codec_kernels_best(void)
{
	return __builtin_cpu_supports("avx2") ? &codec_avx2 : &store_codec_plain;
}

#else

const struct codec_kernels *store_codec_kernels_best(void)
{
	return &store_codec_plain;
}

#endif
