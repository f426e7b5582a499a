#pragma once

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/schemes/scheme.hpp>

namespace semiexplicit {
namespace detail {

/// A decimal number, rounded once to Scalar; other types than the built-in ones are made from the string
/// itself. The tables below have 60 digits.
template <class Scalar>
SEMIEXPLICIT_COLD Scalar decimal(const char* digits) {
  static_assert(std::numeric_limits<Scalar>::digits10 <= 57,
                "the named schemes are known to 60 digits only; refine them for a wider type and use Scheme");
  if constexpr (std::is_floating_point_v<Scalar>) {
    std::istringstream in(digits);
    in.imbue(std::locale::classic());  // whatever the program's locale writes for the point
    Scalar value = 0;
    in >> value;
    return value;
  } else {
    return Scalar(digits);
  }
}

/// The full list from its first half and the middle entry.
template <class Scalar>
SEMIEXPLICIT_COLD std::vector<Scalar> palindrome(std::initializer_list<const char*> half) {
  std::vector<Scalar> list;
  for (const char* digits : half) list.push_back(decimal<Scalar>(digits));
  for (std::size_t i = half.size() - 1; i-- > 0;) list.push_back(Scalar(list[i]));
  return list;
}

/// A scheme from its kicks a0, b0, a1, b1, ...: first half and middle entry.
template <class Scalar>
SEMIEXPLICIT_COLD Scheme<Scalar> direct(const char* name, int order, std::initializer_list<const char*> half,
                                        const char* source) {
  std::vector<Scalar> a, b;
  for (const Scalar& c : palindrome<Scalar>(half)) (a.size() == b.size() ? a : b).push_back(c);
  return Scheme<Scalar>(name, order, std::move(a), std::move(b), source);
}

/// What the kicks of a composition are computed in, so that they, too, are rounded once (nearly so where long
/// double is no wider).
template <class Scalar>
using Intermediate = std::conditional_t<std::is_floating_point_v<Scalar>, long double, Scalar>;

/// A scheme from the weights of its Strang stages.
template <class Scalar>
SEMIEXPLICIT_COLD Scheme<Scalar> stages_of_strang(std::string name, int order,
                                                  const std::vector<Intermediate<Scalar>>& weights,
                                                  const char* source) {
  using Wide = Intermediate<Scalar>;
  const Wide half = Wide(1) / Wide(2);
  const Kicks<Wide> wide = composed_kicks<Wide>({{half, half}, {Wide(1)}}, weights);
  const auto rounded = [](const std::vector<Wide>& list) {
    std::vector<Scalar> result;
    for (const Wide& c : list) result.push_back(static_cast<Scalar>(c));
    return result;
  };
  return Scheme<Scalar>(std::move(name), order, rounded(wide.a), rounded(wide.b), source);
}

/// The same from the first half of the weights and the middle one.
template <class Scalar>
SEMIEXPLICIT_COLD Scheme<Scalar> composition(const char* name, int order,
                                             std::initializer_list<const char*> half, const char* source) {
  return stages_of_strang<Scalar>(name, order, palindrome<Intermediate<Scalar>>(half), source);
}

/// Order by order: `copies` times the method of order n - 2 with the weight g, as many again, and between
/// them one with the weight 1 - 2 copies g. The terms of degree n - 1 cancel for g = 1/(m - m^(1/(n-1))), m =
/// 2 copies.
template <class Wide>
SEMIEXPLICIT_COLD std::vector<Wide> recursive_weights(int order, int copies) {
  using std::pow;
  std::vector<Wide> weights{Wide(1)};
  for (int n = 4; n <= order; n += 2) {
    const Wide m(2 * copies), exponent = Wide(1) / Wide(n - 1);
    const Wide root = pow(m, exponent);
    const Wide outer = Wide(1) / (m - root), middle = Wide(1) - m * outer;
    std::vector<Wide> next;
    for (int i = 0; i <= 2 * copies; ++i)
      for (const Wide& w : weights) next.push_back((i == copies ? middle : outer) * w);
    weights = std::move(next);
  }
  return weights;
}

SEMIEXPLICIT_COLD inline void check_recursive_order(const char* name, int order, int highest) {
  if (order < 2 || order > highest || order % 2 != 0)
    throw std::invalid_argument(std::string("schemes::") + name + ": order " + std::to_string(order) +
                                " is not available; take an even one from 2 to " + std::to_string(highest));
}

inline constexpr const char* low_defect_source = "found for this library; see schemes/named.hpp";

}  // namespace detail

/// The named schemes. "Stages" are Strang steps, of which s make 2s + 1 kicks; a kick is a gradient call. The
/// numbers behind the remarks on accuracy are the error constants that tests/schemes/test_scheme.cpp checks.
namespace schemes {

/// Strang's splitting A(1/2) B(1) A(1/2): order 2, 3 kicks.
template <class Scalar = double>
Scheme<Scalar> strang() {
  return detail::direct<Scalar>("strang", 2, {"0.5", "1"}, "Strang, SIAM J. Numer. Anal. 5 (1968) 506");
}

/// McLachlan's two stages: order 2, 5 kicks; a0 = (y² + 6y - 2)/(12y), y³ = 2√326 - 36. The smallest error of
/// its order, and a hundredth of Strang's defect.
template <class Scalar = double>
Scheme<Scalar> mclachlan2() {
  const std::initializer_list<const char*> half{
      "0.193183327503783573962899765026834035648120724949407447502965",
      "0.5",
      "0.613633344992432852074200469946331928703758550101185104994069",
  };
  return detail::direct<Scalar>("mclachlan2", 2, half,
                                "McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, S m = 2");
}

/// The triple jump of even order 2 to 10, with 2·3^(order/2 - 1) + 1 kicks. Simple, and the least accurate of
/// its order. Throws std::invalid_argument for another order.
template <class Scalar = double>
Scheme<Scalar> triple_jump(int order) {
  detail::check_recursive_order("triple_jump", order, 10);
  return detail::stages_of_strang<Scalar>(
      "triple_jump" + std::to_string(order), order,
      detail::recursive_weights<detail::Intermediate<Scalar>>(order, 1),
      "Suzuki, Phys. Lett. A 146 (1990) 319; Yoshida, Phys. Lett. A 150 (1990) 262");
}

/// Suzuki's fractal of even order 2 to 8, with 2·5^(order/2 - 1) + 1 kicks. Throws std::invalid_argument for
/// another order.
template <class Scalar = double>
Scheme<Scalar> suzuki(int order) {
  detail::check_recursive_order("suzuki", order, 8);
  return detail::stages_of_strang<Scalar>("suzuki" + std::to_string(order), order,
                                          detail::recursive_weights<detail::Intermediate<Scalar>>(order, 2),
                                          "Suzuki, Phys. Lett. A 146 (1990) 319");
}

/// Blanes and Moan: order 4, 13 kicks. The best published one of its order: 65 times less error than the
/// triple jump for the same work.
template <class Scalar = double>
Scheme<Scalar> blanes_moan4() {
  const std::initializer_list<const char*> half{
      "0.0792036964311956694336634958882688575998504189007817717529199",
      "0.209515106613362021274072640029501004319203327601151902306573",
      "0.353172906049773988481061311573121093393550463796403640697440",
      "-0.143851773179818008275115057856527702767638425425777481488082",
      "-0.0420650803577195353681102983025170500728225889034244040699270",
      "0.434336666566455987001042417827026698448435097824625579181509",
      "0.219376955753499754906770981682254198158843412412477983239134",
  };
  return detail::direct<Scalar>("blanes_moan4", 4, half,
                                "Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 2, S6");
}

/// Blanes and Moan: order 6, 21 kicks. The best published one of its order.
template <class Scalar = double>
Scheme<Scalar> blanes_moan6() {
  const std::initializer_list<const char*> half{
      "0.0502627644003926860212216544020741135170416286654542583188841",
      "0.148816447901043231920901005535577594307885532817743065568979",
      "0.413514300428343815063063720133884401201967428734851898681265",
      "-0.132385865767783647448845426598939933736421481310210336916311",
      "0.0450798897943980629688970521245134765904756187037544522418873",
      "0.0673076046921844581502578965926010403082879618209800785690102",
      "-0.188054853819568914799128488918870509335383517104710119162675",
      "0.432666402578173597527667970883545310824899670988672805855344",
      "0.541960678450780134831414740933072482646256069179158639883973",
      "-0.0164045894036176401499814464127840117046516843171856130770215",
      "-0.725525558508691568170937357349347929240714456357018259926669",
  };
  return detail::direct<Scalar>("blanes_moan6", 6, half,
                                "Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 2, S10");
}

/// Yoshida: order 6, 7 stages, 15 kicks.
template <class Scalar = double>
Scheme<Scalar> yoshida6() {
  const std::initializer_list<const char*> half{
      "0.784513610477557263819497633866349875776824417451493384567948",
      "0.235573213359358133684793182978534601686468082103401119003493",
      "-1.17767998417887100694641568096431573463926925263459848447537",
      "1.31518632068391121888424972823886251435195350615940796180786",
  };
  return detail::composition<Scalar>("yoshida6", 6, half,
                                     "Yoshida, Phys. Lett. A 150 (1990) 262, Table 1, solution A");
}

/// Kahan and Li: order 6, 9 stages, 19 kicks.
template <class Scalar = double>
Scheme<Scalar> kahan_li6() {
  const std::initializer_list<const char*> half{
      "0.392161444007314139279250557422671403804934260613434267564649",
      "0.332599136789359438599748637500049646881586944685751613731724",
      "-0.706246172557639359809964819549256459395510666817071608816092",
      "0.0822135962935508002314904481020563311032938911905985199758895",
      "0.798543990934829963398950353048958155211391140654574415087660",
  };
  return detail::composition<Scalar>("kahan_li6", 6, half,
                                     "Kahan and Li, Math. Comp. 66 (1997) 1089, s9odr6a");
}

/// Kahan and Li: order 8, 17 stages, 35 kicks.
template <class Scalar = double>
Scheme<Scalar> kahan_li8() {
  const std::initializer_list<const char*> half{
      "0.130202483088890080878817632096700522357247233899155116793108",
      "0.561162981775108384561964407700150567266159354341727605361557",
      "-0.389474962644847286408078598235248388836068046981025170084668",
      "0.158841906555155600896210745707152481412147809392080657691887",
      "-0.395903894133237577336231539347938936026771485260636831658862",
      "0.184539640978315707091832541533375462818987344076461003379947",
      "0.258374387686322047293979109994939471813076208883569320600356",
      "0.295011723609310298870966240218228112976543230491112721320250",
      "-0.605508533830034511698921079334718587562643297684888846807149",
  };
  return detail::composition<Scalar>("kahan_li8", 8, half,
                                     "Kahan and Li, Math. Comp. 66 (1997) 1089, s17odr8a");
}

/// Suzuki and Umeno, also Yoshida and McLachlan: order 8, 15 stages, 31 kicks; the fewest possible.
template <class Scalar = double>
Scheme<Scalar> suzuki_umeno8() {
  const std::initializer_list<const char*> half{
      "0.741670364350612953448227801783806315603536510079860590239932",
      "-0.409100825800031593997300095893563417309917830234813621291562",
      "0.190754710296238379953876256450371662735460539872510275865233",
      "-0.573862471116082266656387726635535742159509054333269408558661",
      "0.299064181303655923844463540688602988225822885294623982746386",
      "0.334624918245298183784957979882182288633691916310461216537442",
      "0.315293092396766596632056663811002430994080864717213863445453",
      "-0.796887939352916354019788840173733053446331663413173797968445",
  };
  return detail::composition<Scalar>(
      "suzuki_umeno8", 8, half,
      "Suzuki and Umeno, Springer Proc. Phys. 76 (1993) 74; Yoshida 1990, solution D");
}

/// Sofroniou and Spaletta: order 6, 13 stages, 27 kicks.
template <class Scalar = double>
Scheme<Scalar> sofroniou_spaletta6() {
  const std::initializer_list<const char*> half{
      "0.138619308540516952458080130426253537644818247692966347473209",
      "0.133465628510747604070468588322092559649753688853517102217810",
      "0.130705310114492251905427557850152043401431774938328943125206",
      "0.129618937569070347725053665370911841769098869971465513685452",
      "-0.350003248939208965161708309113225605668840428397331985471027",
      "0.118055306530023871702734389540489755365728649314705017664383",
      "0.399077515348715874599887955206651735676018395252698122609933",
  };
  return detail::composition<Scalar>(
      "sofroniou_spaletta6", 6, half,
      "Sofroniou and Spaletta, Optim. Methods Softw. 20 (2005) 597, order 6, 13 stages");
}

/// Sofroniou and Spaletta: order 8, 21 stages, 43 kicks. The smallest error of those published with order 8.
template <class Scalar = double>
Scheme<Scalar> sofroniou_spaletta8() {
  const std::initializer_list<const char*> half{
      "0.106477289845500318239319678548958514957780293985633347995858",
      "0.108374086458357263974334105915459220955800993948328677602830",
      "0.353378210526543424195345413240799339843809431646953027355842",
      "-0.233414140231650821987802811283194796110512118741764697840230",
      "-0.244452667915288412694621714132164173141830964629364355967346",
      "0.113178484357556333147009525155989751045177354867281293253331",
      "0.118929056250003500626929722839508473692534793924053380688160",
      "0.126039123218259881403056702683646233222350730023701801875508",
      "0.125817187361760418043923916415866222034346961947763373953355",
      "0.116991350192176421807228814335329066991943871696218681641962",
      "-0.382635960126436653509446707440395706982802697337609061118540",
  };
  return detail::composition<Scalar>(
      "sofroniou_spaletta8", 8, half,
      "Sofroniou and Spaletta, Optim. Methods Softw. 20 (2005) 597, order 8, 21 stages");
}

/// Sofroniou and Spaletta: order 10, 35 stages, 71 kicks. For the last digits.
template <class Scalar = double>
Scheme<Scalar> sofroniou_spaletta10() {
  const std::initializer_list<const char*> half{
      "0.0787957225216864192639076793376842482198638727665569971412564",
      "0.313096103415108527764812471926472696881054021870436297052577",
      "0.0279183832350780661095202732752988231186749257078930214275868",
      "-0.229592841593907094151213396796549875909924547236536838987650",
      "0.130962061077164863174656859279605412674738501568155779985926",
      "-0.269733405654510714344609732224111497115542051696248013316632",
      "0.0749733431558914356661371056414104123434139256711890794643335",
      "0.111993423999810204889575080736402058720887098426875314354299",
      "0.366133449546226751193148123531499082375253645625191821346841",
      "-0.399105630136035897878629810583404730395862387729558761864117",
      "0.103087398527471077315802770013724479179869985578289827495425",
      "0.411430873955890237820704118976078350507172767778861910088277",
      "-0.00486636058313526176219565930997706302040769200443302465899468",
      "-0.392033353708639906448081936426104269693819342339228303783079",
      "0.0519425029624496470371829040159757277497133836533652857831922",
      "0.0506650907599244963358743441568658941954362273746810855245170",
      "0.0496743706397298790545688002794611763445541575868320178999422",
      "0.0493177357595945379176800083393381476498470147953530100925985",
  };
  return detail::composition<Scalar>(
      "sofroniou_spaletta10", 10, half,
      "Sofroniou and Spaletta, Optim. Methods Softw. 20 (2005) 597, order 10, 35 stages");
}

// The low-defect schemes. A step costs one sweep for every iteration of the projection, and the number of
// iterations depends on the defect between the copies: on the part of the error that is odd under the
// exchange of A and B, which schemes made for other purposes leave as large as the even part. These lists
// were found by minimising both parts of the leading errors together. The order conditions were imposed on
// the even part only, the one that the projected method sees; of the odd part, degree 3 is exactly zero and
// degree 5 is small, but not zero. That takes fewer conditions (14 instead of 26 at order 8) and leaves more
// parameters to minimise with. The price: without the projection the schemes of order 6 and 8 are of order 4
// only. They come with this library and have no other source. The accuracies below are the relative energy
// errors for which each one is the cheapest with the default stopping rule; for accurate trajectories take a
// later one.

/// Order 4, 15 kicks: for relative energy errors of 1e-3 to 1e-5.
template <class Scalar = double>
Scheme<Scalar> low_defect4_s7() {
  const std::initializer_list<const char*> half{
      "0.0554598376392167028638592919621713386394694517721746208232776",
      "0.157980296819125791357332629945109959819955611289135460106872",
      "0.233800936433799982326141654947483953779934861035559618845872",
      "0.254334820657572298745125237164405190809325254707649747782370",
      "0.364205388815848000664479124972990049110354305576688493500035",
      "-0.0360069118159592247876489809102150794241087993398363474033625",
      "-0.153466162888864685854480071882645341529758618384422733169185",
      "0.247383588678522269370382227601399857589655866686102279028241",
  };
  return detail::direct<Scalar>("low_defect4_s7", 4, half, detail::low_defect_source);
}

/// Order 4, 23 kicks: for 1e-6.
template <class Scalar = double>
Scheme<Scalar> low_defect4_s11() {
  const std::initializer_list<const char*> half{
      "0.0417364387954220977243060808486554941691199562995837083695955",
      "0.115094464022182826049113555592895997018725233748191787379406",
      "0.152709779793667198067546730914774918260570921353658850205105",
      "0.227437811035654602127892280325851070119383393814547462663833",
      "-0.0247047682145576286080456575392196006930404464313682151079130",
      "-0.0855586201445511664977854812789815575676220129129355587606325",
      "0.166974331613137172835581919598751098020043858223306038431487",
      "-0.100481480185311333743412161343991505030176630589776214895718",
      "-0.0212336633653201699824625074433677140865036067375025699838927",
      "0.242984167298774505807341880675968956559707836928600913921526",
      "0.184517881377651329963073433620405804329809317292322188085619",
      "0.201047315946501132513699852056514077799964358022743219383171",
  };
  return detail::direct<Scalar>("low_defect4_s11", 4, half, detail::low_defect_source);
}

/// Order 4, 25 kicks: for 1e-6 and 1e-7.
template <class Scalar = double>
Scheme<Scalar> low_defect4_s12() {
  const std::initializer_list<const char*> half{
      "0.0366096931430534005584292403209417033593238630998522842768667",
      "0.101611171595276892513415080696945197591648334267710772884483",
      "0.138185394333891161069655257735262190719766882656783990432829",
      "0.197706610476772384085744432588666650670876254163018623767524",
      "-0.0253301684964909640232884544898808314709887092653838695320775",
      "-0.0614340488342740326929978982087277967084162326025568502553896",
      "0.167926113448669616691136749702435324720581823490318458400193",
      "-0.0703114541300411824500945925851460128749097562028010009356665",
      "-0.0282533746485715204032786408132914204345206684343737649446624",
      "0.179356956227423072036510268710174432170607415363188713428445",
      "0.136032916377298718043490124015620434620633681245036511988971",
      "0.153070764664842866507422708798087529150193985011439741110603",
      "0.149658851684299176127711447057825196970406254415532778755758",
  };
  return detail::direct<Scalar>("low_defect4_s12", 4, half, detail::low_defect_source);
}

/// Order 6, without projection 4; 27 kicks: for 1e-8 to 1e-10. The one to take when in doubt: it also stays
/// good where the stopping rule is strict.
template <class Scalar = double>
Scheme<Scalar> low_defect6_s13() {
  const std::initializer_list<const char*> half{
      "0.0385281858594838555262811389210545192205732668694517962108483",
      "0.0977943110261763009072687721549629805098988718038198453505198",
      "0.110810766171186507012175276599712641608681873631511956196623",
      "0.214284301137267521121697281992838619920551451681175477391865",
      "-0.0868555783955805945116299620361851310202104533020495136450773",
      "0.0421667555150310505129528462559057530310907525019199467706276",
      "0.0308883448535713710193041155126616085937082616173016308809609",
      "-0.114894731607799033058021013992719917728535947266095108752522",
      "0.228314487525896223985281774741174558040816283784879487899612",
      "0.169217406754912821741904321989495122330630628565488427847042",
      "0.189048576549869285011757121463299847721405755854245238300403",
      "0.322222403206629080373889474490480286514855506154123475209354",
      "-0.0107347825644266480431694652017180441649749884553405958433700",
      "-0.461580892064435483199383365781925689156982526880864127633775",
  };
  return detail::direct<Scalar>("low_defect6_s13", 6, half, detail::low_defect_source);
}

/// Order 6, without projection 4; 31 kicks: for 1e-9 to 1e-11.
template <class Scalar = double>
Scheme<Scalar> low_defect6_s15() {
  const std::initializer_list<const char*> half{
      "0.0329478551746639098290265865830865343063406026328828434755923",
      "0.0855576735451430066307835037515260812315193280810903157279392",
      "0.0846148760912482014768661400059512124603649253094075487066955",
      "0.114515183990678681593681829692727873939438339914018805018491",
      "-0.0410265442000983380658085764778491262081136875834505713886444",
      "-0.0372500667608546620825393310231867431936239521560084753700885",
      "0.129406047674786309708965908482007755868970267594290146466664",
      "0.114587184379630010557241945693992331379824437262157125646448",
      "0.149397127418103754094214331306737266089050970873436336007855",
      "0.452768291042307236135702674641564711210013227855542926623039",
      "0.00144827558645305093239558040301380502484864145784629607792062",
      "-0.311810812185217367439406227699642715819949119256503101471657",
      "0.167654130216592149821932783315363083828674021946908226483052",
      "-0.0901634302840888940893621123780522112273063534931054607052223",
      "-0.0244417679617490377975927536183105313701357422313208258291345",
      "0.343591952544803977387795434642141344960168183585615729062103",
  };
  return detail::direct<Scalar>("low_defect6_s15", 6, half, detail::low_defect_source);
}

/// Order 8, without projection 4; 41 kicks: for 1e-11 and less.
template <class Scalar = double>
Scheme<Scalar> low_defect8_s20() {
  const std::initializer_list<const char*> half{
      "0.0488021546340690937986533173948920499385878315738401150477932",
      "0.217997929263762688481702999239624105791261150563046568981400",
      "-0.0619589713136989860514122676120528215426577719124235167573910",
      "-0.0851772818379345723887083477378744041786399100512298234595663",
      "-0.112588521698320645830164781065958610892051970702063620796866",
      "0.0371470939393645899521790189052468988587077881233178962125894",
      "0.0863632184695925041027908044156242749156755523223837827694162",
      "-0.0317497833277698652214180685827911989646820734582087563146035",
      "-0.181766532989045567860704970873686181043350876841683420008959",
      "-0.00617228464593344412599922309936276634311507513405513768331924",
      "0.369506437351076650237458303352619626259919231769149500526452",
      "0.270304802813420520495500218274612227432597577682485534619232",
      "0.00754660156460662268290968900007875726451581719236763000482413",
      "-0.178496869768351945675037335480590604577693797442700740068692",
      "0.164578815842032672356946749601815609574142939881677166358518",
      "0.144966133471833818612114958550453689068225939036879521709320",
      "0.160715226860903147441531819636580121401876973476307443924939",
      "-0.0570232871178436341287082265350112682187665781483952275074626",
      "-0.0411861102461960385423029697790700022765562552068763495382141",
      "0.188203547209451843998374006465693321132104978828860163511103",
      "0.119975363049961095328588611858314352799797056894642536938974",
  };
  return detail::direct<Scalar>("low_defect8_s20", 8, half, detail::low_defect_source);
}

}  // namespace schemes

namespace detail {

template <class Scalar>
struct NamedScheme {
  const char* name;
  Scheme<Scalar> (*make)();
};

template <class Scalar>
SEMIEXPLICIT_COLD const std::vector<NamedScheme<Scalar>>& named_schemes() {
  using namespace schemes;
  static const std::vector<NamedScheme<Scalar>> list{
      {"strang", strang<Scalar>},
      {"mclachlan2", mclachlan2<Scalar>},
      {"triple_jump4", [] { return triple_jump<Scalar>(4); }},
      {"suzuki4", [] { return suzuki<Scalar>(4); }},
      {"blanes_moan4", blanes_moan4<Scalar>},
      {"low_defect4_s7", low_defect4_s7<Scalar>},
      {"low_defect4_s11", low_defect4_s11<Scalar>},
      {"low_defect4_s12", low_defect4_s12<Scalar>},
      {"triple_jump6", [] { return triple_jump<Scalar>(6); }},
      {"suzuki6", [] { return suzuki<Scalar>(6); }},
      {"yoshida6", yoshida6<Scalar>},
      {"kahan_li6", kahan_li6<Scalar>},
      {"sofroniou_spaletta6", sofroniou_spaletta6<Scalar>},
      {"blanes_moan6", blanes_moan6<Scalar>},
      {"low_defect6_s13", low_defect6_s13<Scalar>},
      {"low_defect6_s15", low_defect6_s15<Scalar>},
      {"triple_jump8", [] { return triple_jump<Scalar>(8); }},
      {"suzuki8", [] { return suzuki<Scalar>(8); }},
      {"suzuki_umeno8", suzuki_umeno8<Scalar>},
      {"kahan_li8", kahan_li8<Scalar>},
      {"sofroniou_spaletta8", sofroniou_spaletta8<Scalar>},
      {"low_defect8_s20", low_defect8_s20<Scalar>},
      {"sofroniou_spaletta10", sofroniou_spaletta10<Scalar>},
  };
  return list;
}

}  // namespace detail

namespace schemes {

/// The names that by_name() knows, by order.
SEMIEXPLICIT_COLD inline std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const auto& entry : semiexplicit::detail::named_schemes<double>()) list.push_back(entry.name);
  return list;
}

/// The scheme of that name, for programs that let their user choose. Throws std::invalid_argument, with the
/// list of the names, for an unknown one.
template <class Scalar = double>
SEMIEXPLICIT_COLD Scheme<Scalar> by_name(const std::string& name) {
  for (const auto& entry : semiexplicit::detail::named_schemes<Scalar>())
    if (name == entry.name) return entry.make();
  std::string valid;
  for (const std::string& known : names()) valid += (valid.empty() ? "" : ", ") + known;
  throw std::invalid_argument("schemes::by_name: no scheme is called \"" + name + "\"; the names are " +
                              valid);
}

}  // namespace schemes

/// The scheme to begin with: order 6, blanes_moan6 for a separable Hamiltonian and low_defect6_s13 for any
/// other.
template <class Scalar = double>
Scheme<Scalar> usual_scheme(bool separable) {
  return separable ? schemes::blanes_moan6<Scalar>() : schemes::low_defect6_s13<Scalar>();
}

}  // namespace semiexplicit
