/* SPDX-License-Identifier: MIT */
#include "flash_log.h"

#include <string.h>

#include "board.h"
#include "drehgeber/crc.h"
#include "port.h"

#define XIP 0x10000000u
#define AREA 0x1F0000u
#define SECTOR 4096u
#define PAGE 256u
#define HALF (8u * SECTOR)
#define PAGES (HALF / PAGE)
#define ROOM 240u
#define PIECES_MAX 80u

struct page {
    uint32_t crc;      /* of all that follows */
    uint32_t sequence; /* one more for each page */
    uint32_t id;       /* of the layout */
    uint16_t piece;
    uint8_t left; /* pages of the group behind this one */
    uint8_t of;   /* its last page would be number `of` if the first were 1 */
    uint8_t bytes[ROOM];
};
_Static_assert(sizeof(struct page) == PAGE, "a page is what flash programs at once");

static uint8_t shadow[PIECES_MAX * ROOM];  /* the memory */
static uint8_t written[PIECES_MAX * ROOM]; /* as it was at the sync that is being written */
static bool dirty[PIECES_MAX];
static bool synced; /* there is something to write behind */

static uint32_t size, pieces, id;
static uint32_t half;     /* in use */
static uint32_t next;     /* page of it */
static uint32_t sequence; /* of the next page */
static uint32_t to_erase; /* sectors of the other half, from its beginning */

struct flash_log_counters flash_log_counters;

/* ------------------------------------------------------------ flash */

/* At 14h the ROM has where its table of functions is, at 18h what finds one by two letters (data
   sheet, 2.8.3). */
extern const uint16_t rom_tables[3]; /* of link.ld */

static uintptr_t rom(char first, char second)
{
    uintptr_t (*const find)(uint32_t, uint32_t) =
        (uintptr_t(*)(uint32_t, uint32_t))(uintptr_t)rom_tables[2];

    return find(rom_tables[0], (uint32_t)(uint8_t)second << 8 | (uint8_t)first);
}

static void find_rom_function(char first, char second)
{
    ((void (*)(void))rom(first, second))();
}

/* Interrupts go on: nothing of theirs is in flash. */
static void leave_xip(void)
{
    find_rom_function('I', 'F');
    find_rom_function('E', 'X');
}

static void enter_xip(void)
{
    find_rom_function('F', 'C');
    find_rom_function('C', 'X');
}

static uint32_t page_address_of(uint32_t of_half, uint32_t page)
{
    return AREA + of_half * HALF + page * PAGE;
}

static const struct page *page_at(uint32_t of_half, uint32_t page)
{
    return (const struct page *)(uintptr_t)(XIP + page_address_of(of_half, page));
}

static void erase_sector(uint32_t of_half, uint32_t sector)
{
    const uint32_t address = page_address_of(of_half, 0) + sector * SECTOR;

    leave_xip();
    ((void (*)(uint32_t, uint32_t, uint32_t, uint32_t))rom('R', 'E'))(address, SECTOR, 1u << 16,
                                                                      0xD8u);
    enter_xip();
    flash_log_counters.sectors++;
}

static bool program_page(const struct page *from)
{
    const uint32_t address = page_address_of(half, next);

    leave_xip();
    ((void (*)(uint32_t, const void *, uint32_t))rom('R', 'P'))(address, from, PAGE);
    enter_xip();
    flash_log_counters.pages++;
    if (memcmp(page_at(half, next++), from, PAGE) != 0) {
        flash_log_counters.bad++;
        return false;
    }
    return true;
}

static bool blank(uint32_t of_half, uint32_t first, uint32_t n)
{
    const uint32_t *at = (const uint32_t *)(const void *)page_at(of_half, first);

    for (uint32_t i = 0; i < n * PAGE / sizeof *at; i++) {
        if (at[i] != UINT32_MAX) {
            return false;
        }
    }
    return true;
}

/* ------------------------------------------------------------ reading the log */

static uint32_t sum_of(const struct page *page)
{
    return dg_crc32(0, (const uint8_t *)&page->sequence, PAGE - sizeof page->crc);
}

static bool is_page_whole(const struct page *page)
{
    return page->id == id && page->piece < pieces && page->left < page->of &&
           page->crc == sum_of(page);
}

/* @return pages of the group that begins there, all of them whole; 0: none does */
static uint32_t group_at(uint32_t of_half, uint32_t first)
{
    const struct page *page = page_at(of_half, first);

    if (!is_page_whole(page) || page->left + 1u != page->of || first + page->of > PAGES) {
        return 0;
    }
    const uint32_t n = page->of;
    for (uint32_t i = 1; i < n; i++) {
        const struct page *follows = page + i;
        if (!is_page_whole(follows) || follows->sequence != page->sequence + i ||
            follows->left + i + 1u != n) {
            return 0;
        }
    }
    return n;
}

static void apply_page(uint32_t of_half, uint32_t first, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        const struct page *page = page_at(of_half, first + i);
        memcpy(shadow + page->piece * ROOM, page->bytes, ROOM);
    }
}

/* The half whose first group is the newer one. */
static bool find_half(void)
{
    const bool there[2] = {group_at(0, 0) == pieces, group_at(1, 0) == pieces};
    const int32_t newer = (int32_t)(page_at(1, 0)->sequence - page_at(0, 0)->sequence);

    half = there[1] && (!there[0] || newer > 0);
    return there[0] || there[1];
}

static void read_log(void)
{
    for (next = 0; next < PAGES;) {
        const uint32_t n = group_at(half, next);
        apply_page(half, next, n);
        if (is_page_whole(page_at(half, next))) {
            sequence = page_at(half, next)->sequence + 1u;
        }
        if (n == 0 && blank(half, next, PAGES - next)) {
            break;
        }
        sequence = n == 0 ? sequence : page_at(half, next + n - 1u)->sequence + 1u;
        next += n == 0 ? 1u : n; /* a torn one is left behind */
    }
}

/* ------------------------------------------------------------ writing it */

static bool write_group(const bool *wanted, uint32_t n)
{
    static struct page page;
    uint32_t left = n;

    for (uint32_t i = 0; i < pieces; i++) {
        if (!wanted[i]) {
            continue;
        }
        page.sequence = sequence++;
        page.id = id;
        page.piece = (uint16_t)i;
        page.left = (uint8_t)--left;
        page.of = (uint8_t)n;
        memcpy(page.bytes, written + i * ROOM, ROOM);
        page.crc = sum_of(&page);
        if (!program_page(&page)) {
            return false;
        }
    }
    return true;
}

static void erase_next(void)
{
    to_erase--;
    if (!blank(1u - half, to_erase * (SECTOR / PAGE), SECTOR / PAGE)) {
        erase_sector(1u - half, to_erase);
    }
}

/* All of it, into the other half. */
static bool change_halves(void)
{
    bool all[PIECES_MAX];

    const uint32_t before = flash_log_counters.sectors;
    while (to_erase > 0) {
        erase_next();
    }
    flash_log_counters.late += flash_log_counters.sectors - before;
    memset(all, true, sizeof all);
    half = 1u - half;
    next = 0;
    to_erase = HALF / SECTOR;
    return write_group(all, pieces);
}

/* What has changed since the last time, as it is now. @return how many pieces */
static uint32_t take_changes(bool *changed)
{
    uint32_t n = 0;

    board_lock();
    memcpy(written, shadow, pieces * ROOM);
    memcpy(changed, dirty, sizeof dirty);
    memset(dirty, false, sizeof dirty);
    synced = false;
    board_unlock();
    for (uint32_t i = 0; i < pieces; i++) {
        n += changed[i];
    }
    return n;
}

static int flush_log(void)
{
    bool changed[PIECES_MAX];
    const uint32_t n = take_changes(changed);

    if (n == 0) {
        return DG_OK;
    }
    const bool done = next + n <= PAGES && write_group(changed, n);
    /* A half that is full, or bad, is left. */
    return done || change_halves() || change_halves() ? DG_OK : DG_ERR_IO;
}

/* ------------------------------------------------------------ the memory */

static int read(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    if (address > size || n > size - address) {
        return DG_ERR_IO;
    }
    if (n > 1u) { /* a register is a byte; a region is read whole in order to write it */
        port_stores();
    }
    memcpy(to, shadow + address, n);
    return DG_OK;
}

static int write(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    if (address > size || n > size - address) {
        return DG_ERR_IO;
    }
    port_stores();
    memcpy(shadow + address, from, n);
    for (uint32_t i = address / ROOM; n > 0 && i <= (address + n - 1u) / ROOM; i++) {
        dirty[i] = true;
    }
    return DG_OK;
}

static int sync(void *ctx)
{
    (void)ctx;
    synced = true;
    return flash_log_behind ? DG_OK : flush_log();
}

struct dg_nvm flash_log_open(const struct dg_store_layout *layout)
{
    static const struct dg_nvm_ops ops = {.read = read, .write = write, .sync = sync};

    if (layout == NULL) {
        return (struct dg_nvm){.ops = NULL};
    }
    id = layout->id;
    size = dg_store_size(layout);
    pieces = (size + ROOM - 1u) / ROOM;
    memset(shadow, 0xFF, sizeof shadow);
    to_erase = HALF / SECTOR;
    if (pieces > PIECES_MAX) {
        return (struct dg_nvm){.ops = NULL};
    }
    if (find_half()) {
        read_log();
    } else {
        next = PAGES; /* the first group goes to the other half */
    }
    return (struct dg_nvm){.ops = &ops};
}

/* Pages that a half has left for each sector of the other one that is to be erased, when it is time
   for that: from its middle on, one for some four writes. */
#define PAGES_PER_SECTOR (PAGES / 2u / (HALF / SECTOR))

static bool pressing(void)
{
    return PAGES - next < to_erase * PAGES_PER_SECTOR;
}

dg_ns flash_log_loop(bool idle, bool pause)
{
    if (synced) {
        (void)flush_log();
    } else if (to_erase > 0 && (idle || (pause && pressing()))) {
        erase_next();
    }
    return to_erase > 0 ? board_now() + DG_MS(10) : DG_NEVER;
}
