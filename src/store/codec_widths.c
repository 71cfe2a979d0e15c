/*
 * A canonical Huffman code of at most 8 bits a symbol. Shorter codes come first; of codes of one
 * length, those of smaller symbols.
 *
 * Four streams have a quarter of the symbols each. A CPU decodes them at once, because none waits
 * for another.
 */
#include "store/codec_widths.h"

#include <assert.h>
#include <string.h>

#include "store/codec_parts.h"

#define SIZES_BYTES (2 * (WIDTHS_STREAMS - 1))
#define ALL_BITS (1u << WIDTHS_BITS_MOST)
#define SYMBOLS_MOST 6 /* in an entry of the table */
#define ENTRIES 6 /* read at once: 48 of the 57 bits that eight bytes have after a part of a byte  \
	           */
#define SYMBOLS_ROOM (ENTRIES * SYMBOLS_MOST + 8) /* that these may write */

/* --- the code --- */

struct node {
	uint32_t count;
	int16_t left, right; /* nodes; a leaf has no left: -1, and its symbol in `right` */
};

/* Sorts leaves by count, then by symbol. There are few. */
static int take_leaves(const uint32_t counts[WIDTHS_SYMBOLS], struct node nodes[])
{
	int leaves = 0;
	for (int symbol = 0; symbol < WIDTHS_SYMBOLS; symbol++) {
		if (counts[symbol] == 0)
			continue;
		int at = leaves++;
		for (; at > 0 && nodes[at - 1].count > counts[symbol]; at--)
			nodes[at] = nodes[at - 1];
		nodes[at] = (struct node){counts[symbol], -1, (int16_t)symbol};
	}
	return leaves;
}

/* Sets the lengths of an optimal code for at least two symbols. Returns the greatest. */
static unsigned take_lengths(const uint32_t counts[WIDTHS_SYMBOLS], uint8_t lengths[WIDTHS_SYMBOLS])
{
	struct node nodes[2 * WIDTHS_SYMBOLS];
	uint8_t depth[2 * WIDTHS_SYMBOLS] = {0};
	int leaves = take_leaves(counts, nodes), leaf = 0, inner = leaves, count = leaves;
	assert(leaves >= 2);
	while (count <
	       2 * leaves -
	               1) { /* joins the two rarest; leaves and inner nodes are each in order */
		int16_t two[2];
		for (int i = 0; i < 2; i++)
			two[i] =
			        (int16_t)(leaf < leaves && (inner >= count ||
			                                    nodes[leaf].count <= nodes[inner].count)
			                          ? leaf++
			                          : inner++);
		nodes[count++] =
		        (struct node){nodes[two[0]].count + nodes[two[1]].count, two[0], two[1]};
	}
	unsigned most = 0;
	for (int i = count - 1; i >= 0; i--) {
		if (nodes[i].left >= 0) {
			depth[nodes[i].left] = depth[nodes[i].right] = (uint8_t)(depth[i] + 1);
		} else {
			lengths[nodes[i].right] = depth[i];
			most = depth[i] > most ? depth[i] : most;
		}
	}
	return most;
}

static unsigned reverse(unsigned code, unsigned bits)
{
	unsigned reversed = 0;
	for (unsigned i = 0; i < bits; i++)
		reversed |= (code >> i & 1) << (bits - 1 - i);
	return reversed;
}

/* Sets the codes of given lengths. Returns the part of all codes of WIDTHS_BITS_MOST bits that they
 * use: ALL_BITS is all. */
static unsigned take_codes(struct widths_code *code)
{
	unsigned next = 0;
	for (unsigned bits = 1; bits <= WIDTHS_BITS_MOST; bits++) {
		next <<= 1;
		for (int symbol = 0; symbol < WIDTHS_SYMBOLS; symbol++)
			if (code->lengths[symbol] == bits)
				code->codes[symbol] = (uint16_t)reverse(next++, bits);
		if (next > 1u << bits)
			return ALL_BITS + 1;
	}
	return next;
}

void store_widths_plan(const uint32_t counts[WIDTHS_SYMBOLS], struct widths_code *code)
{
	uint32_t some[WIDTHS_SYMBOLS];
	int used = 0;
	*code = (struct widths_code){0};
	for (int symbol = 0; symbol < WIDTHS_SYMBOLS; symbol++) {
		some[symbol] = counts[symbol];
		used += counts[symbol] > 0;
	}
	for (int symbol = 0; used < 2; symbol++) /* a code has two at least */
		if (some[symbol] == 0) {
			some[symbol] = 1;
			used++;
		}
	while (take_lengths(some, code->lengths) > WIDTHS_BITS_MOST)
		for (int symbol = 0; symbol < WIDTHS_SYMBOLS; symbol++)
			some[symbol] =
			        (some[symbol] + 1) / 2; /* nearer each other: a flatter code */
	unsigned all = take_codes(code);
	assert(all == ALL_BITS);
	(void)all;
}

/* --- writing --- */

size_t store_widths_bound(size_t count)
{
	return 1 + (WIDTHS_SYMBOLS + 1) / 2 + SIZES_BYTES + (count * WIDTHS_BITS_MOST + 7) / 8 +
	       WIDTHS_STREAMS * 8;
}

uint8_t *store_widths_put_table(const struct widths_code *code, uint8_t *to)
{
	unsigned count = WIDTHS_SYMBOLS;
	while (code->lengths[count - 1] == 0)
		count--;
	*to++ = (uint8_t)count;
	for (unsigned i = 0; i < count; i += 2)
		*to++ = (uint8_t)(code->lengths[i] |
		                  (i + 1 < count ? code->lengths[i + 1] << 4 : 0));
	return to;
}

static uint8_t *put_stream(const struct widths_code *code, const uint8_t *symbols, size_t count,
                           uint8_t *to)
{
	uint64_t bits = 0;
	unsigned have = 0;
	for (size_t i = 0; i < count; i++) {
		bits |= (uint64_t)code->codes[symbols[i]] << have;
		have += code->lengths[symbols[i]];
		if (have >= 32) {
			put32(to, (uint32_t)bits);
			to += 4;
			bits >>= 32;
			have -= 32;
		}
	}
	for (; have > 0; have = have > 8 ? have - 8 : 0, bits >>= 8)
		*to++ = (uint8_t)bits;
	return to;
}

static size_t stream_count(size_t count, int stream)
{
	size_t quarter = (count + WIDTHS_STREAMS - 1) / WIDTHS_STREAMS;
	return stream < WIDTHS_STREAMS - 1 ? quarter : count - (WIDTHS_STREAMS - 1) * quarter;
}

uint8_t *store_widths_put(const struct widths_code *code, const uint8_t *symbols, size_t count,
                          uint8_t *to)
{
	uint8_t *sizes = to;
	assert(count >= WIDTHS_LEAST);
	to += SIZES_BYTES;
	for (int stream = 0; stream < WIDTHS_STREAMS; stream++) {
		uint8_t *begin = to;
		to = put_stream(code, symbols, stream_count(count, stream), to);
		symbols += stream_count(count, stream);
		assert(to - begin <= UINT16_MAX);
		if (stream < WIDTHS_STREAMS - 1) {
			sizes[2 * stream] = (uint8_t)(to - begin);
			sizes[2 * stream + 1] = (uint8_t)((to - begin) >> 8);
		}
	}
	return to;
}

/* --- reading --- */

/* An entry has the codes that are whole in its byte. */
static void fill_table(struct widths_table *table)
{
	for (unsigned byte = 0; byte < ALL_BITS; byte++) {
		uint64_t entry = 0;
		unsigned bits = 0, count = 0;
		for (unsigned next; count < SYMBOLS_MOST; bits += next >> 8) {
			next = table->first[byte >> bits];
			if (bits + (next >> 8) > WIDTHS_BITS_MOST)
				break;
			entry |= (uint64_t)(next & 255) << 8 * count++;
		}
		table->all[byte] = entry | (uint64_t)count << 48 | (uint64_t)bits << 56;
	}
}

bool store_widths_get_table(const uint8_t **from, size_t *left, struct widths_table *table)
{
	struct widths_code code = {0};
	const uint8_t *at = *from;
	if (*left < 1 || at[0] < 2 || at[0] > WIDTHS_SYMBOLS || *left < 1 + (at[0] + 1u) / 2)
		return false;
	const unsigned count = at[0], bytes = 1 + (count + 1) / 2;
	for (unsigned i = 0; i < count; i++) {
		code.lengths[i] = (uint8_t)(at[1 + i / 2] >> 4 * (i % 2) & 15);
		if (code.lengths[i] > WIDTHS_BITS_MOST)
			return false;
	}
	if (take_codes(&code) != ALL_BITS)
		return false;
	for (unsigned i = 0; i < count; i++)
		for (unsigned entry = code.codes[i]; code.lengths[i] > 0 && entry < ALL_BITS;
		     entry += 1u << code.lengths[i])
			table->first[entry] = (uint16_t)(i | (unsigned)code.lengths[i] << 8);
	fill_table(table);
	*from += bytes;
	*left -= bytes;
	return true;
}

struct stream {
	const uint8_t *from;
	size_t size, at; /* bytes; bits that are read */
	uint8_t *to, *end;
};

/* Returns true if stream_some() reads and writes within the stream. */
static inline bool has_some(const struct stream *stream)
{
	return stream->at / 8 + 8 <= stream->size && stream->end - stream->to >= SYMBOLS_ROOM;
}

static inline void put64(uint8_t *to, uint64_t value)
{
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
	value = __builtin_bswap64(value);
#endif
	memcpy(to, &value, sizeof value);
}

/* Decodes the codes of some bytes. */
static inline __attribute__((always_inline)) void stream_some(struct stream *stream,
                                                              const uint64_t *all)
{
	uint64_t bits = load64(stream->from + stream->at / 8) >> stream->at % 8;
	uint8_t *to = stream->to;
	for (int i = 0; i < ENTRIES; i++) {
		uint64_t entry = all[bits & (ALL_BITS - 1)];
		put64(to, entry); /* what is written after its symbols is written again */
		to += entry >> 48 & 255;
		bits >>= entry >> 56;
		stream->at += entry >> 56;
	}
	stream->to = to;
}

/* Decodes the codes of a byte, where eight symbols may be written. */
static inline __attribute__((always_inline)) bool stream_byte(struct stream *stream,
                                                              const uint64_t *all)
{
	if (stream->at / 8 + 8 > stream->size || stream->end - stream->to < 8)
		return false;
	uint64_t entry =
	        all[load64(stream->from + stream->at / 8) >> stream->at % 8 & (ALL_BITS - 1)];
	put64(stream->to, entry);
	stream->to += entry >> 48 & 255;
	stream->at += entry >> 56;
	return true;
}

/* The last symbols, one at a time. After the last byte follow zeros. */
static bool stream_rest(struct stream *stream, const uint16_t *first)
{
	while (stream->to < stream->end) {
		size_t byte = stream->at / 8;
		uint32_t bits = byte < stream->size ? stream->from[byte] : 0;
		bits |= byte + 1 < stream->size ? (uint32_t)stream->from[byte + 1] << 8 : 0;
		unsigned next = first[bits >> stream->at % 8 & (ALL_BITS - 1)];
		*stream->to++ = (uint8_t)next;
		stream->at += next >> 8;
	}
	return stream->at <= 8 * stream->size;
}

/* A CPU works ahead in all streams, since what it does in one does not depend on the others. */
static bool read_streams(struct stream streams[WIDTHS_STREAMS], const struct widths_table *table)
{
	bool some = true, good = true;
	while (some) {
		some = false;
		for (int i = 0; i < WIDTHS_STREAMS; i++)
			if (has_some(&streams[i])) {
				stream_some(&streams[i], table->all);
				some = true;
			}
	}
	for (some = true; some;) {
		some = false;
		for (int i = 0; i < WIDTHS_STREAMS; i++)
			some |= stream_byte(&streams[i], table->all);
	}
	for (int i = 0; i < WIDTHS_STREAMS; i++)
		good = stream_rest(&streams[i], table->first) && good;
	return good;
}

bool store_widths_get(const struct widths_table *table, const uint8_t *from, size_t size,
                      uint8_t *symbols, size_t count)
{
	struct stream streams[WIDTHS_STREAMS];
	assert(count >= WIDTHS_LEAST);
	if (size < SIZES_BYTES)
		return false;
	const uint8_t *sizes = from;
	from += SIZES_BYTES;
	size -= SIZES_BYTES;
	for (int i = 0; i < WIDTHS_STREAMS; i++) {
		size_t bytes = i < WIDTHS_STREAMS - 1 ? sizes[2 * i] | (size_t)sizes[2 * i + 1] << 8
		                                      : size;
		if (bytes > size)
			return false;
		streams[i] =
		        (struct stream){from, bytes, 0, symbols, symbols + stream_count(count, i)};
		symbols = streams[i].end;
		from += bytes;
		size -= bytes;
	}
	return read_streams(streams, table);
}
