/*
 * The text of a URDF as MuJoCo reads it. Other programs take what MuJoCo refuses or mixes up, so the text is changed before it is parsed:
 *
 * 1. Every mesh file gets a name of its own. MuJoCo knows a mesh by the last part of its file's name, and would take left/wheel.stl for right/wheel.stl.
 * 2. A link that is only seen collides with what is seen. That is so for all links of a model that has no collision. Else it is so for those that turn
 *    without end and have none.
 * 3. Of several materials of one visual the first counts. Commas between numbers are blanks.
 *
 * Lines keep their numbers, so MuJoCo's messages fit the file.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/check.h"
#include "vehicle/spec.h"
#include "vehicle/xml.h"

struct link {
	const char *name;
	size_t length;
	bool collides, seen, turns, counts; /* counts: what is seen of it collides */
};

struct rewrite {
	struct spec *spec;
	const char *text, *copied; /* up to here it is in `out` */
	size_t length;
	char *out;
	size_t used, room;
	struct link *links;
	size_t link_count, link_room;
	const char **turning;      /* names of links below continuous joints, and their lengths */
	size_t *turning_lengths;
	size_t turning_count, turning_room, turning_lengths_room;
	size_t commas, materials;
	enum status status;
};

/* --- what there is --- */

static bool same(const char *a, size_t length, const char *b, size_t other)
{
	return length == other && memcmp(a, b, length) == 0;
}

static bool find_attribute(struct vehicle_xml xml, const char *name, struct vehicle_xml_attribute *out)
{
	while (vehicle_xml_attribute(&xml, out))
		if (vehicle_xml_is(out->name, out->name_length, name))
			return true;
	return false;
}

static enum status add_link(struct rewrite *rewrite, const struct vehicle_xml *xml)
{
	struct vehicle_xml_attribute name;
	TRY(mem_grow(&rewrite->links, &rewrite->link_room, rewrite->link_count + 1, sizeof *rewrite->links, "a vehicle"));
	const bool named = find_attribute(*xml, "name", &name);
	rewrite->links[rewrite->link_count++] = (struct link){.name = named ? name.value : "", .length = named ? name.value_length : 0};
	return STATUS_OK;
}

static enum status add_turning(struct rewrite *rewrite, const struct vehicle_xml *xml)
{
	struct vehicle_xml_attribute name;
	if (!find_attribute(*xml, "link", &name))
		return STATUS_OK;
	TRY(mem_grow(&rewrite->turning, &rewrite->turning_room, rewrite->turning_count + 1, sizeof *rewrite->turning, "a vehicle"));
	TRY(mem_grow(&rewrite->turning_lengths, &rewrite->turning_lengths_room, rewrite->turning_count + 1, sizeof *rewrite->turning_lengths, "a vehicle"));
	rewrite->turning[rewrite->turning_count] = name.value;
	rewrite->turning_lengths[rewrite->turning_count++] = name.value_length;
	return STATUS_OK;
}

static bool parse_number_of(struct vehicle_xml xml, const char *name, double *out)
{
	struct vehicle_xml_attribute found;
	char text[64];
	if (!find_attribute(xml, name, &found))
		return false;
	snprintf(text, sizeof text, "%.*s", (int)(found.value_length < sizeof text ? found.value_length : sizeof text - 1), found.value);
	*out = strtod(text, NULL);
	return true;
}

/* A joint that follows another one. */
static enum status add_mimic(struct rewrite *rewrite, const struct vehicle_xml *xml, const struct vehicle_xml_attribute *joint)
{
	struct spec *spec = rewrite->spec;
	struct vehicle_xml_attribute of;
	if (joint->value == NULL || !find_attribute(*xml, "joint", &of))
		return STATUS_OK;
	TRY(mem_grow(&spec->mimics, &spec->mimic_room, spec->mimic_count + 1, sizeof *spec->mimics, "a vehicle"));
	struct spec_mimic *mimic = &spec->mimics[spec->mimic_count];
	*mimic = (struct spec_mimic){.times = 1};
	snprintf(mimic->joint, sizeof mimic->joint, "%.*s", (int)joint->value_length, joint->value);
	snprintf(mimic->of, sizeof mimic->of, "%.*s", (int)of.value_length, of.value);
	(void)parse_number_of(*xml, "multiplier", &mimic->times);
	(void)parse_number_of(*xml, "offset", &mimic->plus);
	spec->mimic_count++;
	return STATUS_OK;
}

static enum status find_parts(struct rewrite *rewrite)
{
	struct vehicle_xml xml = vehicle_xml_begin(rewrite->text, rewrite->length);
	struct vehicle_xml_attribute joint = {NULL, NULL, 0, 0}, type;
	bool in_link = false, continuous = false;
	for (enum vehicle_xml_event event; (event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE;) {
		if (event == VEHICLE_XML_CLOSE)
			continue;
		if (xml.depth == 2) {
			in_link = vehicle_xml_is(xml.name, xml.name_length, "link");
			const bool is_joint = vehicle_xml_is(xml.name, xml.name_length, "joint");
			continuous = is_joint && find_attribute(xml, "type", &type) && vehicle_xml_is(type.value, type.value_length, "continuous");
			if (!is_joint || !find_attribute(xml, "name", &joint))
				joint.value = NULL;
			if (in_link)
				TRY(add_link(rewrite, &xml));
		} else if (xml.depth == 3 && in_link) {
			struct link *link = &rewrite->links[rewrite->link_count - 1];
			link->collides = link->collides || vehicle_xml_is(xml.name, xml.name_length, "collision");
			link->seen = link->seen || vehicle_xml_is(xml.name, xml.name_length, "visual");
		} else if (xml.depth == 3 && continuous && vehicle_xml_is(xml.name, xml.name_length, "child")) {
			TRY(add_turning(rewrite, &xml));
		} else if (xml.depth == 3 && vehicle_xml_is(xml.name, xml.name_length, "mimic")) {
			TRY(add_mimic(rewrite, &xml, &joint));
		}
	}
	return STATUS_OK;
}

/* A joint whose link is not in the file: MuJoCo tells the line alone. */
static enum status check_joints(const struct rewrite *rewrite)
{
	struct vehicle_xml xml = vehicle_xml_begin(rewrite->text, rewrite->length);
	struct vehicle_xml_attribute joint = {"", "", 0, 0}, link;
	bool in_joint = false;
	for (enum vehicle_xml_event event; (event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE;) {
		if (event == VEHICLE_XML_CLOSE)
			continue;
		if (xml.depth == 2)
			in_joint = vehicle_xml_is(xml.name, xml.name_length, "joint") && find_attribute(xml, "name", &joint);
		const bool parent = vehicle_xml_is(xml.name, xml.name_length, "parent");
		if (xml.depth != 3 || !in_joint || (!parent && !vehicle_xml_is(xml.name, xml.name_length, "child")) || !find_attribute(xml, "link", &link))
			continue;
		bool found = false;
		for (size_t i = 0; i < rewrite->link_count && !found; i++)
			found = same(rewrite->links[i].name, rewrite->links[i].length, link.value, link.value_length);
		if (!found)
			return fail_with(STATUS_INPUT, "%s: %s: joint %.*s: its %s %.*s is no link of the file; correct the name, or take the joint out", rewrite->spec->where, rewrite->spec->path,
					 (int)(joint.value_length < 64 ? joint.value_length : 64), joint.value, parent ? "parent" : "child",
					 (int)(link.value_length < 64 ? link.value_length : 64), link.value);
	}
	return STATUS_OK;
}

/* Decides which links collide with what is seen of them. */
static void choose_seen(struct rewrite *rewrite)
{
	struct spec_names turning = {.count = 0};
	bool any = false;
	size_t all = 0;
	for (size_t i = 0; i < rewrite->link_count; i++)
		any = any || rewrite->links[i].collides;
	for (size_t i = 0; i < rewrite->link_count; i++) {
		struct link *link = &rewrite->links[i];
		char name[64];
		for (size_t k = 0; k < rewrite->turning_count && !link->turns && !link->collides; k++)
			link->turns = same(link->name, link->length, rewrite->turning[k], rewrite->turning_lengths[k]);
		link->counts = link->seen && !link->collides && (!any || link->turns);
		all += link->counts && !any;
		snprintf(name, sizeof name, "%.*s", (int)(link->length < 48 ? link->length : 48), link->name);
		if (link->counts && any)
			vehicle_spec_name(&turning, name);
	}
	if (all > 0)
		vehicle_spec_tell(rewrite->spec, "none of its links has a collision: what is seen of %zu collides", all);
	if (turning.count > 0)
		vehicle_spec_tell(rewrite->spec, "%s turn%s and ha%s no collision: what is seen of %s collides", turning.text, turning.count > 1 ? "" : "s", turning.count > 1 ? "ve" : "s",
				  turning.count > 1 ? "them" : "it");
}

/* --- the new text --- */

static void put(struct rewrite *rewrite, const char *text, size_t length)
{
	if (rewrite->status == STATUS_OK)
		rewrite->status = mem_grow(&rewrite->out, &rewrite->room, rewrite->used + length + 1, 1, "a vehicle");
	if (rewrite->status != STATUS_OK)
		return;
	memcpy(rewrite->out + rewrite->used, text, length);
	rewrite->used += length;
	rewrite->out[rewrite->used] = '\0';
}

static void copy_to(struct rewrite *rewrite, const char *to)
{
	put(rewrite, rewrite->copied, (size_t)(to - rewrite->copied));
	rewrite->copied = to;
}

/* Puts another text in place of `length` bytes at `from`. */
static void replace(struct rewrite *rewrite, const char *from, size_t length, const char *by)
{
	copy_to(rewrite, from);
	put(rewrite, by, strlen(by));
	rewrite->copied = from + length;
}

/* Leaves out what is between, but for its ends of lines. */
static void leave_out(struct rewrite *rewrite, const char *from, const char *to)
{
	copy_to(rewrite, from);
	for (; from < to; from++)
		if (*from == '\n')
			put(rewrite, "\n", 1);
	rewrite->copied = to;
}

static void decode(const char *text, size_t length, char *out)
{
	static const struct {
		const char *entity;
		char is;
	} known[] = {{"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&lt;", '<'}, {"&gt;", '>'}};
	for (size_t i = 0; i < length;) {
		size_t k = 0;
		while (k < 5 && !(length - i >= strlen(known[k].entity) && memcmp(text + i, known[k].entity, strlen(known[k].entity)) == 0))
			k++;
		*out++ = k < 5 ? known[k].is : text[i];
		i += k < 5 ? strlen(known[k].entity) : 1;
	}
	*out = '\0';
}

static enum status find_mesh(struct spec *spec, const struct vehicle_xml_attribute *file, size_t *number)
{
	char *name = mem_alloc(file->value_length + 1, 1);
	TRY_MEM(name, "a vehicle");
	decode(file->value, file->value_length, name);
	for (*number = 0; *number < spec->file_count && strcmp(spec->files[*number], name) != 0;)
		(*number)++;
	if (*number < spec->file_count) {
		mem_free(name);
		return STATUS_OK;
	}
	const enum status status = mem_grow(&spec->files, &spec->file_room, spec->file_count + 1, sizeof *spec->files, "a vehicle");
	if (status == STATUS_OK)
		spec->files[spec->file_count++] = name;
	else
		mem_free(name);
	return status;
}

static void name_mesh(struct rewrite *rewrite, const struct vehicle_xml_attribute *file)
{
	char text[48];
	size_t number = 0;
	if (rewrite->status == STATUS_OK)
		rewrite->status = find_mesh(rewrite->spec, file, &number);
	if (rewrite->status != STATUS_OK)
		return;
	snprintf(text, sizeof text, SPEC_FILE "%zu.mesh", number);
	replace(rewrite, file->value, file->value_length, text);
}

static void blank_commas(struct rewrite *rewrite, const struct vehicle_xml_attribute *attribute)
{
	static const char *const numbers[] = {"xyz", "rpy", "size", "scale", "rgba"};
	bool is_number = false;
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		is_number = is_number || vehicle_xml_is(attribute->name, attribute->name_length, numbers[i]);
	if (!is_number || memchr(attribute->value, ',', attribute->value_length) == NULL)
		return;
	rewrite->commas++;
	for (size_t i = 0; i < attribute->value_length; i++)
		if (attribute->value[i] == ',')
			replace(rewrite, attribute->value + i, 1, " ");
}

static void take_attributes(struct rewrite *rewrite, struct vehicle_xml xml)
{
	struct vehicle_xml_attribute attribute;
	const bool mesh = vehicle_xml_is(xml.name, xml.name_length, "mesh");
	while (vehicle_xml_attribute(&xml, &attribute))
		if (mesh && vehicle_xml_is(attribute.name, attribute.name_length, "filename"))
			name_mesh(rewrite, &attribute);
		else
			blank_commas(rewrite, &attribute);
}

static void write_all(struct rewrite *rewrite)
{
	struct vehicle_xml xml = vehicle_xml_begin(rewrite->text, rewrite->length);
	size_t link = 0, materials = 0;
	bool in_link = false, in_visual = false;
	const char *from = NULL; /* a material that is left out begins here */
	for (enum vehicle_xml_event event; (event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE;) {
		const bool opens = event == VEHICLE_XML_OPEN;
		const int depth = xml.depth + !opens; /* of the element */
		if (!opens && from != NULL && depth == 4) {
			leave_out(rewrite, from, xml.at);
			from = NULL;
			continue;
		}
		if (from != NULL)
			continue;
		if (opens && depth == 2) {
			in_link = vehicle_xml_is(xml.name, xml.name_length, "link");
			link += in_link;
		}
		if (depth == 3 && in_link && vehicle_xml_is(xml.name, xml.name_length, "visual")) {
			in_visual = opens;
			materials = 0;
			if (rewrite->links[link - 1].counts && (opens || xml.name[-1] == '/'))
				replace(rewrite, xml.name, xml.name_length, "collision");
		}
		if (opens && in_visual && depth == 4 && vehicle_xml_is(xml.name, xml.name_length, "material") && materials++ > 0) {
			rewrite->materials++;
			from = xml.name - 1;
		} else if (opens) {
			take_attributes(rewrite, xml);
		}
	}
	copy_to(rewrite, rewrite->text + rewrite->length);
}

enum status vehicle_spec_text(struct spec *spec, char **out)
{
	struct vehicle_check check = {.where = spec->where, .path = spec->path};
	struct rewrite rewrite = {.spec = spec, .status = STATUS_OK};
	char *text = NULL;
	enum status status;
	*out = NULL;
	spec->mimic_count = 0;
	TRY_OR(done, vehicle_check_read(&check, spec->path, &text, &rewrite.length));
	rewrite.text = rewrite.copied = text;
	TRY_OR(done, find_parts(&rewrite));
	TRY_OR(done, check_joints(&rewrite));
	choose_seen(&rewrite);
	write_all(&rewrite);
	status = rewrite.status;
	if (rewrite.commas > 0)
		vehicle_spec_tell(spec, "%zu of its attributes ha%s commas between numbers: they are taken as blanks", rewrite.commas, rewrite.commas > 1 ? "ve" : "s");
done:
	mem_free_all(text, rewrite.links, rewrite.turning, rewrite.turning_lengths);
	if (status == STATUS_OK)
		*out = rewrite.out;
	else
		mem_free(rewrite.out);
	return status;
}

const char *vehicle_spec_file(const struct spec *spec, const char *name)
{
	const size_t length = strlen(SPEC_FILE);
	const char *digits = strncmp(name, SPEC_FILE, length) == 0 ? name + length : NULL;
	const size_t number = digits != NULL ? strtoul(digits, NULL, 10) : spec->file_count;
	return number < spec->file_count ? spec->files[number] : name;
}

void vehicle_spec_free(struct spec *spec)
{
	for (size_t i = 0; i < spec->file_count; i++)
		mem_free(spec->files[i]);
	mem_free_all(spec->files, spec->mimics, spec->told);
}
