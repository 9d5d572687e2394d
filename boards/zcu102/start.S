/* The first instructions: one processor goes on, at whatever exception level the loader left it, with its floating
 * point unit on, a stack, and cleared memory. An exception ends in a report and a stop. */
    .section .text.start, "ax"
    .global _start
_start:
    msr     daifset, #0xf       /* interrupts wake, they do not interrupt */
    mrs     x0, mpidr_el1
    tst     x0, #0xff
    b.ne    park

    adr     x1, vectors
    mrs     x0, CurrentEL
    cmp     x0, #(3 << 2)
    b.eq    at_el3
    cmp     x0, #(2 << 2)
    b.eq    at_el2
    msr     vbar_el1, x1
    b       floating_point
at_el3:
    msr     vbar_el3, x1
    msr     cptr_el3, xzr       /* no trap of floating point */
    mrs     x0, scr_el3
    orr     x0, x0, #(1 << 1)   /* route interrupts here: so that they wake the processor */
    msr     scr_el3, x0
    b       floating_point
at_el2:
    msr     vbar_el2, x1
    mov     x0, #0x33ff         /* no trap of floating point */
    msr     cptr_el2, x0
    mov     x0, #(1 << 4)       /* route interrupts here */
    msr     hcr_el2, x0
floating_point:
    mov     x0, #(3 << 20)
    msr     cpacr_el1, x0
    isb
    msr     fpcr, xzr           /* IEEE 754: round to nearest, denormal numbers kept */

    ldr     x0, =stack_top
    mov     sp, x0
    ldr     x0, =bss_begin
    ldr     x1, =bss_end
clear:
    cmp     x0, x1
    b.hs    cleared
    str     xzr, [x0], #8
    b       clear
cleared:
    bl      main
    bl      zcu102_exit
park:
    wfi
    b       park

    .align  11
vectors:
    .rept   16
    b       fault
    .align  7
    .endr
fault:
    mrs     x0, CurrentEL
    cmp     x0, #(3 << 2)
    b.eq    fault_el3
    cmp     x0, #(2 << 2)
    b.eq    fault_el2
    mrs     x0, esr_el1
    mrs     x1, elr_el1
    b       zcu102_fault
fault_el3:
    mrs     x0, esr_el3
    mrs     x1, elr_el3
    b       zcu102_fault
fault_el2:
    mrs     x0, esr_el2
    mrs     x1, elr_el2
    b       zcu102_fault
